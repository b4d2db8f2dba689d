#pragma once

#include <chrono>
#include <mutex>
#include <string>

/// @file
/// How far a long job is.

namespace vantage {

/// On stderr: a bar with the time left that is written over where that is a terminal, a line every few seconds
/// elsewhere. Of quick jobs nothing. From any thread.
class ProgressBar {
 public:
  explicit ProgressBar(bool quiet);
  /// @param share  Of the whole that is done, in [0, 1].
  /// @param text   What is being done, or how many of how many.
  void Show(double share, const std::string& text);
  /// Another job begins: the time left is told of it alone.
  void Restart();
  /// Takes the bar away.
  void End();

 private:
  using Clock = std::chrono::steady_clock;

  std::mutex mutex_;
  bool shown_, terminal_;
  bool written_{false};
  Clock::time_point start_, last_;
};

}  // namespace vantage
