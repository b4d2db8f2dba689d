#include "sim/rig_plant.h"

#include <algorithm>

#include "vantage/math/error.h"

namespace vantage::sim {

RigPlant::RigPlant(CameraRig rig, const RigVector& q_c_start)
    : rig_(std::move(rig)), q_c_(q_c_start) {
  Validate(rig_);
  if (q_c_.size() != rig_.size()) {
    throw ConfigError("", "camera_rig.start",
                      "needs " + std::to_string(rig_.size()) + " coordinates, found " +
                          std::to_string(q_c_.size()));
  }
  target_ = q_c_;
}

void RigPlant::Accept(const CameraPose& command) {
  if (!IsPose(command.X_WC)) return;
  target_ = NearestRigCoordinates(rig_, command.X_WC, q_c_);
}

void RigPlant::Step(double dt) {
  for (int i = 0; i < rig_.size(); ++i) {
    const double reach = rig_.axes[static_cast<std::size_t>(i)].max_speed * dt;
    q_c_(i) += std::clamp(target_(i) - q_c_(i), -reach, reach);
  }
}

}  // namespace vantage::sim
