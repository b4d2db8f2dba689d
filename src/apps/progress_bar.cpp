#include "progress_bar.h"

#include <algorithm>
#include <iostream>

#include <unistd.h>

#include "vantage/math/format.h"

namespace vantage {
namespace {

constexpr std::chrono::milliseconds kOnTerminal{100};
constexpr std::chrono::seconds kElsewhere{5};
// Before that much of the time has passed, what is left is a guess that jumps [s].
constexpr double kGuess = 1.0;

}  // namespace

ProgressBar::ProgressBar(bool quiet)
    : shown_(!quiet), terminal_(isatty(STDERR_FILENO) != 0), start_(Clock::now()), last_(start_) {}

void ProgressBar::Show(double share, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Clock::time_point now = Clock::now();
  if (!shown_ ||
      now - last_ < (terminal_ ? Clock::duration(kOnTerminal) : Clock::duration(kElsewhere))) {
    return;
  }
  last_ = now;
  written_ = true;
  share = std::clamp(share, 0.0, 1.0);
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  std::string line = Format("%3.0f %%  ", 100.0 * share) + text;
  if (elapsed > kGuess && share > 0.0) {
    line += Format(", %.0f s left", elapsed * (1.0 - share) / share);
  }
  if (!terminal_) {
    std::cerr << line << std::endl;
    return;
  }
  constexpr int kWidth = 30;
  const auto filled = static_cast<int>(kWidth * share);
  std::cerr << "\r\033[K[" << std::string(filled, '#') << std::string(kWidth - filled, '.') << "] "
            << line << std::flush;
}

void ProgressBar::Restart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  start_ = Clock::now();
}

void ProgressBar::End() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (written_ && terminal_) std::cerr << "\r\033[K" << std::flush;
  written_ = false;
}

}  // namespace vantage
