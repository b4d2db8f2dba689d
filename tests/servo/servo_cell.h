#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "sim/arm_plant.h"
#include "test_arm.h"
#include "vantage/servo/camera_task.h"
#include "vantage/servo/servo.h"

/// @file
/// A servo in a cell without pixels, in lockstep: the simulator's arm with its monitor, a camera that
/// projects by the model, and messages that a test may spoil on their way.

namespace vantage::test {

inline constexpr int kGoalId = 100;  ///< First marker of a goal that is seen.

struct CellOptions {
  ServoOptions servo;
  double lag{0.02};            ///< Of the arm's velocity loop [s].
  int periods_per_image{10};   ///< 50 images a second.
  int latency_images{1};       ///< Between exposure and arrival.
  bool goal_seen{false};       ///< Markers of the goal are in the image; else the goal is known.
  double goal_max_speed{0.0};  ///< As the servo is told [m/s].
};

/// What reaches the servo in one period.
struct Deliveries {
  std::vector<JointState> joints;
  std::vector<CameraPose> poses;
  std::vector<ImageFeatures> images;
};

class ServoCell {
 public:
  ServoCell(const ViewModel& view, const JointVector& q_start, const JointVector& q_goal,
            const CellOptions& options = {})
      : view_(view),
        options_(options),
        arm_(view.arm, q_start, Effects(options), 1),
        p_WG_(MarkersAt(view, q_goal)),
        servo_(MakeServo()) {}

  /// One period: the world moves on, `spoil` has its way with the messages, the servo commands.
  const ServoOutput& Tick(const std::function<void(Deliveries*)>& spoil = {}) {
    ++tick_;
    arm_.Step(now(), kPeriod);
    const JointState joints = arm_.Read(now());
    Deliveries d{{joints}, {}, {}};
    if (tick_ % 2 == 0) d.poses.push_back({now(), X_WC});
    if (tick_ % options_.periods_per_image == 0) images_.push_back(Expose());
    const auto latency = static_cast<std::size_t>(options_.latency_images);
    if (tick_ % options_.periods_per_image == 0 && images_.size() > latency) {
      images_.front().stamp = now();
      d.images.push_back(images_.front());
      images_.pop_front();
    }
    if (spoil) spoil(&d);
    for (const JointState& v : d.joints) servo_.Accept(v, now());
    for (const CameraPose& v : d.poses) servo_.Accept(v, now());
    for (const ImageFeatures& v : d.images) servo_.Accept(v, now());
    const ServoOutput& output = servo_.Step(now());
    arm_.Accept(output.command, now());
    return output;
  }

  [[nodiscard]] Time now() const { return Time(FromSeconds(1.0 + tick_ * kPeriod)); }
  [[nodiscard]] double time() const { return tick_ * kPeriod; }  ///< [s].
  [[nodiscard]] const sim::ArmPlant& arm() const { return arm_; }
  [[nodiscard]] Servo& servo() { return servo_; }
  [[nodiscard]] const ViewModel& view() const { return view_; }
  /// Forgets the servo and starts another, as a restarted program does.
  void RestartServo() { servo_ = MakeServo(); }

  /// RMS distance in the true image between markers and goals [px].
  [[nodiscard]] double TrueError() const {
    const std::vector<Eigen::Vector3d> markers = MarkersAt(view_, arm_.q());
    double sum = 0.0;
    for (std::size_t i = 0; i < markers.size(); ++i) {
      sum += (PixelOf(markers[i]) - PixelOf(p_WG_[i] + goal_shift)).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(markers.size()));
  }

  Eigen::Isometry3d X_WC{LookFrom({1.2, -1.5, 1.0})};   ///< The camera, now.
  Eigen::Vector3d goal_shift{Eigen::Vector3d::Zero()};  ///< By how much the goal has moved [m].

 private:
  static ArmEffects Effects(const CellOptions& options) {
    ArmEffects effects;
    effects.lag = options.lag;
    return effects;
  }

  [[nodiscard]] Servo MakeServo() const {
    ServoTask task{view_, {}};
    task.goal.p_WG = p_WG_;
    task.goal.max_speed = options_.goal_max_speed;
    if (options_.goal_seen) {
      for (std::size_t i = 0; i < p_WG_.size(); ++i) {
        task.goal.marker_ids.push_back(kGoalId + static_cast<int>(i));
        task.goal.normals.emplace_back(Eigen::Vector3d::UnitZ());
      }
    }
    ServoOptions servo = options_.servo;
    servo.period = kPeriod;
    servo.convergence.max_mm_per_px =
        25.0;  // from there one pixel hides 18 mm along the line of sight
    return {task, servo, TriggerOptions()};
  }

  [[nodiscard]] Eigen::Vector2d PixelOf(const Eigen::Vector3d& p_W) const {
    return ToPixel(view_.camera, Project(X_WC.inverse() * p_W)->n);
  }

  [[nodiscard]] ImageFeatures Expose() const {
    ImageFeatures image;
    image.exposure = now();
    image.X_WC = X_WC;
    const auto add = [&](int id, const Eigen::Vector3d& p_W) {
      image.markers[static_cast<std::size_t>(image.count++)] = {id, PixelOf(p_W), true};
    };
    const std::vector<Eigen::Vector3d> markers = MarkersAt(view_, arm_.q());
    for (std::size_t i = 0; i < markers.size(); ++i) add(view_.markers[i].id, markers[i]);
    for (std::size_t i = 0; options_.goal_seen && i < p_WG_.size(); ++i) {
      add(kGoalId + static_cast<int>(i), p_WG_[i] + goal_shift);
    }
    return image;
  }

  ViewModel view_;
  CellOptions options_;
  sim::ArmPlant arm_;
  std::vector<Eigen::Vector3d> p_WG_;
  Servo servo_;
  std::deque<ImageFeatures> images_;
  int tick_{0};
};

}  // namespace vantage::test
