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

std::string Cell(const MessageField& field) {
  if (const auto* integer = std::get_if<std::int64_t>(&field.value))
    return std::to_string(*integer);
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

// One file: its columns in the order they were first seen, and what waits to be written to it.
class Table {
 public:
  void AddColumns(const std::vector<MessageField>& fields) {
    for (const MessageField& field : fields) {
      if (columns_.try_emplace(field.name, names_.size()).second) names_.push_back(field.name);
    }
  }

  // Begins the file; all columns are known.
  void Begin(const std::string& path) {
    path_ = path;
    waiting_ = "log_time";
    for (const std::string& name : names_) waiting_ += ',' + name;
    waiting_ += '\n';
    Flush(std::ios::trunc);
  }

  void Add(std::int64_t utime, const std::vector<MessageField>& fields) {
    std::vector<std::string> cells(names_.size());
    for (const MessageField& field : fields) cells[columns_.at(field.name)] = Cell(field);
    char time[32];
    std::snprintf(time, sizeof time, "%.6f", 1e-6 * static_cast<double>(utime));
    waiting_ += time;
    for (const std::string& cell : cells) waiting_ += ',' + cell;
    waiting_ += '\n';
    if (waiting_.size() > kMostWaiting) Flush(std::ios::app);
  }

  void End() { Flush(std::ios::app); }

  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  // Opened anew each time: a log may have more channels than a process may have files.
  void Flush(std::ios::openmode mode) {
    std::ofstream file(path_, mode);
    file << waiting_ << std::flush;
    if (!file) throw WriteError(path_);
    waiting_.clear();
  }

  static constexpr std::size_t kMostWaiting = 1 << 18;
  std::vector<std::string> names_;
  std::unordered_map<std::string, std::size_t> columns_;
  std::string path_, waiting_;
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

// Calls take(table's name, time, fields) for each line that the log's messages make.
template <typename Take>
void ForEachLine(const std::string& log_path, const Take& take) {
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
    take(FileName(event.channel), event.utime, content.fields);
    for (const MessageTable& part : content.tables) {
      const std::string name = FileName(event.channel + "." + part.name);
      for (const auto& row : part.rows) take(name, event.utime, row);
    }
  }
}

}  // namespace

// The log is read twice, first for the columns: so a log of hours takes no more memory than one of seconds.
std::vector<std::string> ExportCsv(const std::string& log_path, const std::string& folder) {
  using Fields = std::vector<MessageField>;
  std::map<std::string, Table> tables;
  ForEachLine(log_path, [&](const std::string& name, std::int64_t, const Fields& fields) {
    tables[name].AddColumns(fields);
  });
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw WriteError(folder);
  std::vector<std::string> paths;
  for (auto& [name, table] : tables) {
    table.Begin(folder + "/" + name + ".csv");
    paths.push_back(table.path());
  }
  ForEachLine(log_path, [&](const std::string& name, std::int64_t utime, const Fields& fields) {
    tables.at(name).Add(utime, fields);
  });
  for (auto& entry : tables) entry.second.End();
  return paths;
}

}  // namespace vantage
