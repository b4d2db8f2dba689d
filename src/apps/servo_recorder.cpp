#include "servo_recorder.h"

namespace vantage {
namespace {

constexpr std::size_t kQueuedPeriods = 1000;
constexpr std::size_t kQueuedSteps = 100;
constexpr std::size_t kPeriodsInRecord = 200;  // Keeps a message far below its cap.
constexpr Duration kRecordPeriod = std::chrono::milliseconds(20);
constexpr Duration kSetupPeriod = std::chrono::seconds(1);

}  // namespace

ServoRecorder::ServoRecorder(ServoSetup setup, LcmLink* link)
    : setup_(std::move(setup)), link_(link), periods_(kQueuedPeriods), camera_steps_(kQueuedSteps) {
  record_.start = setup_.start;
}

void ServoRecorder::Note(const PeriodRecord& period) noexcept {
  if (!periods_.try_enqueue(period)) ++lost_;
}

void ServoRecorder::Note(const CameraStepRecord& step) noexcept {
  if (!camera_steps_.try_enqueue(step)) ++lost_;
}

void ServoRecorder::Publish(Time now, bool last) {
  if (now >= next_setup_) {
    next_setup_ = now + kSetupPeriod;
    setup_.stamp = now;
    link_->Publish(kServoSetupChannel, setup_);
  }
  if (now < next_record_ && !last) return;
  next_record_ = now + kRecordPeriod;
  do {
    record_.stamp = now;
    record_.lost = lost_;
    record_.periods.clear();
    record_.camera_steps.clear();
    PeriodRecord period;
    while (record_.periods.size() < kPeriodsInRecord && periods_.try_dequeue(period)) {
      record_.periods.push_back(period);
    }
    // After the periods: the steps that these have used are in the queue by now.
    CameraStepRecord step;
    while (camera_steps_.try_dequeue(step)) record_.camera_steps.push_back(step);
    link_->Publish(kServoInputsChannel, record_);
  } while (record_.periods.size() == kPeriodsInRecord);
}

}  // namespace vantage
