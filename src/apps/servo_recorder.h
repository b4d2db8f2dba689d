#pragma once

#include <readerwriterqueue/readerwriterqueue.h>

#include "vantage/messaging/lcm_link.h"
#include "vantage/servo/servo_record.h"

namespace vantage {

/// Publishes what every control period took as its inputs (SERVO_INPUTS, SERVO_SETUP), so that a log of a
/// run can be replayed to the same numbers. Three threads meet here, each with functions of its own.
class ServoRecorder {
 public:
  /// @param setup  Its stamp is set anew at each sending.
  ServoRecorder(ServoSetup setup, LcmLink* link);

  /// Control thread. Real-time safe: when the publisher is a second behind, periods are lost and counted.
  void Note(const PeriodRecord& period) noexcept;
  /// Camera thread; before the output of the step is given to the control thread.
  void Note(const CameraStepRecord& step) noexcept;

  /// Publisher thread: sends what was noted, when it is time to. `last`: whatever the time.
  void Publish(Time now, bool last = false);

 private:
  ServoSetup setup_;
  LcmLink* link_;
  moodycamel::ReaderWriterQueue<PeriodRecord> periods_;
  moodycamel::ReaderWriterQueue<CameraStepRecord> camera_steps_;
  std::atomic<std::int64_t> lost_{0};
  ServoRecord record_;  // Being sent; keeps its memory.
  Time next_record_{};
  Time next_setup_{};
};

}  // namespace vantage
