#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace vantage {

/// Records every message on every channel into an event log, as lcm-logger does, but within this process:
/// what is published after the constructor has returned is recorded.
class EventRecorder {
 public:
  /// Throws Error when the file cannot be written, ConfigError when the URL is none.
  EventRecorder(const std::string& url, const std::string& path);
  /// Takes what has arrived and closes the file.
  ~EventRecorder();
  EventRecorder(const EventRecorder&) = delete;
  EventRecorder& operator=(const EventRecorder&) = delete;

  /// Messages that could not be written (disk full).
  [[nodiscard]] std::int64_t lost() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage
