#include "vantage/servo/servo_record.h"

namespace vantage {

const ServoOutput& RunPeriod(Servo* servo, const PeriodInputs& inputs) noexcept {
  if (inputs.has_joints) servo->Accept(inputs.joints, inputs.now);
  if (inputs.has_pose) servo->Accept(inputs.pose, inputs.now);
  if (inputs.has_features) servo->Accept(inputs.features, inputs.now);
  if (inputs.has_active) servo->Accept(inputs.active);
  if (!inputs.enabled) servo->SetEnabled(false);
  return servo->Step(inputs.now);
}

}  // namespace vantage
