#include "csv_export.h"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <unordered_map>

#include "vantage/math/error.h"
#include "vantage/messaging/event_log.h"
#include "vantage/messaging/message_fields.h"

namespace vantage {
namespace {

/// Columns of one table in the order they were first seen, and its lines.
class Table {
 public:
  void Add(std::int64_t utime, const std::vector<MessageField>& fields) {
    lines_.push_back({utime, {}});
    std::vector<std::string>& cells = lines_.back().cells;
    for (const MessageField& field : fields) {
      const auto [column, is_new] = columns_.try_emplace(field.name, names_.size());
      if (is_new) names_.push_back(field.name);
      if (cells.size() <= column->second) cells.resize(column->second + 1);
      cells[column->second] = Cell(field);
    }
  }

  void Write(const std::string& path) const {
    std::ofstream file(path);
    file << "log_time";
    for (const std::string& name : names_) file << ',' << name;
    file << '\n';
    for (const Line& line : lines_) {
      char time[32];
      std::snprintf(time, sizeof time, "%.6f", 1e-6 * static_cast<double>(line.utime));
      file << time;
      for (std::size_t i = 0; i < names_.size(); ++i) {
        file << ',';
        if (i < line.cells.size()) file << line.cells[i];
      }
      file << '\n';
    }
    file.flush();
    if (!file) throw WriteError(path);
  }

 private:
  struct Line {
    std::int64_t utime;
    std::vector<std::string> cells;
  };

  static std::string Cell(const MessageField& field) {
    if (const auto* integer = std::get_if<std::int64_t>(&field.value)) {
      return std::to_string(*integer);
    }
    if (const auto* number = std::get_if<double>(&field.value)) {
      char buffer[40];
      // The shortest text that reads back as the same number.
      const auto end = std::to_chars(buffer, buffer + sizeof buffer, *number).ptr;
      return {buffer, end};
    }
    std::string quoted = "\"";
    for (const char c : std::get<std::string>(field.value)) {
      quoted += c;
      if (c == '"') quoted += c;
    }
    return quoted + '"';
  }

  std::vector<std::string> names_;
  std::unordered_map<std::string, std::size_t> columns_;
  std::vector<Line> lines_;
};

// A channel's name may hold anything.
std::string FileName(const std::string& channel) {
  std::string name = channel;
  for (char& c : name) {
    const bool plain = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                       c == '_' || c == '-' || c == '.';
    if (!plain) c = '_';
  }
  return name;
}

}  // namespace

std::vector<std::string> ExportCsv(const std::string& log_path, const std::string& folder) {
  std::map<std::string, Table> tables;
  EventLogReader log(log_path);
  for (LoggedEvent event; log.Next(&event);) {
    const MessageLayout* layout = FindLayout(event.data.data(), event.data.size());
    if (layout == nullptr) continue;
    MessageContent content;
    try {
      content = ContentOf(*layout, event.data.data(), event.data.size());
    } catch (const Error&) {
      continue;  // Refused, and counted where the log is read for the report.
    }
    tables[FileName(event.channel)].Add(event.utime, content.fields);
    for (const MessageTable& part : content.tables) {
      Table& table = tables[FileName(event.channel + "." + part.name)];
      for (const auto& row : part.rows) table.Add(event.utime, row);
    }
  }
  std::filesystem::create_directories(folder);
  std::vector<std::string> paths;
  for (const auto& [name, table] : tables) {
    paths.push_back(folder + "/" + name + ".csv");
    table.Write(paths.back());
  }
  return paths;
}

}  // namespace vantage
