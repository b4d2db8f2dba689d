#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "vantage/messaging/codec.h"

/// @file
/// LCM event logs: what lcm-logger writes and lcm-logplayer plays.

namespace vantage {

/// One message of a log.
struct LoggedEvent {
  std::int64_t utime{0};  ///< When it was recorded: the logger's wall clock [us].
  std::string channel;    ///< As on the network, prefix included.
  Bytes data;             ///< The message as it was sent, fingerprint first.
};

/// Reads a log from its begin.
class EventLogReader {
 public:
  /// Throws ConfigError when the file cannot be read or is no event log.
  explicit EventLogReader(const std::string& path);
  ~EventLogReader();
  EventLogReader(const EventLogReader&) = delete;
  EventLogReader& operator=(const EventLogReader&) = delete;

  /// The next message; false at the end, which is also where a log that was cut off ends.
  bool Next(LoggedEvent* event);

  /// Bytes of the file that belong to no message given so far. At the end: what was cut off or damaged.
  [[nodiscard]] std::int64_t damaged_bytes() const noexcept { return left_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::int64_t left_{0};
};

/// Writes a log.
class EventLogWriter {
 public:
  /// Throws WriteError when the file cannot be written.
  explicit EventLogWriter(const std::string& path);
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  /// Throws WriteError when the disk is full.
  void Write(const LoggedEvent& event);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage
