#include "vantage/messaging/event_log.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <lcm/lcm-cpp.hpp>

#include "vantage/math/error.h"

namespace vantage {
namespace {

// In front of every event.
constexpr std::array<unsigned char, 4> kSync{0xED, 0xA1, 0xDA, 0x01};
// With the event's number, stamp, and the lengths of channel and data.
constexpr std::int64_t kHeaderBytes = 28;

// An empty log is a log; a file that begins with anything else than an event is none.
void CheckIsLog(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw ConfigError(path, "", "is a directory");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw ConfigError(path, "", std::string("cannot be opened: ") + std::strerror(errno));
  std::array<char, 4> begin{};
  file.read(begin.data(), begin.size());
  if (file.gcount() == 0) return;
  if (file.gcount() < 4 || std::memcmp(begin.data(), kSync.data(), kSync.size()) != 0) {
    throw ConfigError(path, "", "is not an LCM event log");
  }
}

}  // namespace

struct EventLogReader::Impl {
  explicit Impl(const std::string& path) : file(path, "r") {}
  lcm::LogFile file;
};

EventLogReader::EventLogReader(const std::string& path) {
  CheckIsLog(path);
  impl_ = std::make_unique<Impl>(path);
  if (!impl_->file.good()) throw ConfigError(path, "", "cannot be read");
  std::error_code no_size;
  const std::uintmax_t size = std::filesystem::file_size(path, no_size);
  left_ = no_size ? 0 : static_cast<std::int64_t>(size);
}

EventLogReader::~EventLogReader() = default;

bool EventLogReader::Next(LoggedEvent* event) {
  const lcm::LogEvent* next = impl_->file.readNextEvent();
  if (next == nullptr) return false;
  event->utime = next->timestamp;
  event->channel = next->channel;
  const auto* data = static_cast<const std::uint8_t*>(next->data);
  event->data.assign(data, data + next->datalen);
  left_ -= kHeaderBytes + static_cast<std::int64_t>(event->channel.size()) + next->datalen;
  return true;
}

struct EventLogWriter::Impl {
  explicit Impl(const std::string& log_path) : path(log_path), file(path, "w") {}
  std::string path;
  lcm::LogFile file;
};

EventLogWriter::EventLogWriter(const std::string& path) : impl_(std::make_unique<Impl>(path)) {
  if (!impl_->file.good()) throw WriteError(path);
}

EventLogWriter::~EventLogWriter() = default;

void EventLogWriter::Write(const LoggedEvent& event) {
  lcm::LogEvent out;
  out.timestamp = event.utime;
  out.channel = event.channel;
  out.datalen = static_cast<std::int32_t>(event.data.size());
  out.data = const_cast<std::uint8_t*>(event.data.data());  // Only read; LCM's struct has no const.
  if (impl_->file.writeEvent(&out) != 0) throw WriteError(impl_->path);
}

}  // namespace vantage
