#pragma once

#include <array>

#include "vantage/camera/camera_rig.h"
#include "vantage/math/sizes.h"

/// @file
/// Motion of a camera rig: a smooth curve through its coordinates, and a timing along it that keeps
/// every axis within its speed and acceleration and the camera within its linear speed.

namespace vantage {

/// A curve in rig coordinates, s in [0, 1]: a clamped uniform cubic B-spline, smooth to the second
/// derivative. It stays inside every box that holds its points, so inside the rig's limits when they
/// are, and starts and ends at the first and the last of them.
class RigPath {
 public:
  static constexpr int kPoints = 8;           ///< Control points.
  static constexpr int kSpans = kPoints - 3;  ///< Cubic pieces.

  RigPath() = default;

  /// Evenly along the straight line.
  [[nodiscard]] static RigPath Straight(const RigVector& start, const RigVector& end);
  /// The parabola (1-s)² start + 2 s (1-s) control + s² end, exactly.
  [[nodiscard]] static RigPath Parabola(const RigVector& start, const RigVector& control,
                                        const RigVector& end);
  /// Parameter in whose neighbourhood a control point pulls the curve: its Greville abscissa.
  [[nodiscard]] static double Station(int point) noexcept;

  /// Control point i.
  [[nodiscard]] const RigVector& point(int i) const noexcept { return points_[i]; }
  /// Control point i, to be moved.
  [[nodiscard]] RigVector& point(int i) noexcept { return points_[i]; }
  [[nodiscard]] const RigVector& start() const noexcept { return points_.front(); }
  [[nodiscard]] const RigVector& end() const noexcept { return points_.back(); }

  /// The same way from a start close by: the first points move along, the others stay.
  [[nodiscard]] RigPath StartingAt(const RigVector& start) const;

  /// Coordinates after the share s of the path, 0 to 1.
  [[nodiscard]] RigVector At(double s) const noexcept;
  [[nodiscard]] RigVector Slope(double s) const noexcept;  ///< dq/ds.
  [[nodiscard]] RigVector Bend(double s) const noexcept;   ///< d²q/ds²; linear within each span.
  /// Bound on the size of each component of Slope(), everywhere.
  [[nodiscard]] RigVector SlopeBound() const noexcept;
  /// Sum of the distances between the control points over all coordinates [m + rad]: at least the
  /// curve's length.
  [[nodiscard]] double Length() const noexcept;

 private:
  // Control points of the first and the second derivative.
  [[nodiscard]] RigVector SlopePoint(int i) const noexcept;
  [[nodiscard]] RigVector BendPoint(int i) const noexcept;

  std::array<RigVector, kPoints> points_;
};

/// A rig on its way along a path. From rest to rest; braking and going on again are part of it. Between
/// steps the path's parameter accelerates evenly, so bounds hold at every instant, not at steps alone.
class RigMotion {
 public:
  /// At rest at q_c.
  explicit RigMotion(const RigVector& q_c);

  /// About to leave path.start(), at rest. An axis that is locked must not move on the path.
  RigMotion(const CameraRig& rig, const RigPath& path);

  /// Moves on for dt seconds; with `brake`, towards rest as fast as the bounds allow, still on the
  /// path. Real-time safe.
  /// @pre dt >= 0.
  void Step(double dt, bool brake) noexcept;

  [[nodiscard]] const RigPath& path() const noexcept { return path_; }
  [[nodiscard]] double s() const noexcept { return s_; }
  [[nodiscard]] RigVector q_c() const noexcept { return path_.At(s_); }
  /// Velocity along the rig's axes at this instant [m/s, rad/s].
  [[nodiscard]] RigVector qdot_c() const noexcept { return rate_ * path_.Slope(s_); }
  /// Where it would come to rest if it braked now.
  [[nodiscard]] RigVector StopCoordinates() const noexcept;
  [[nodiscard]] bool AtRest() const noexcept { return rate_ == 0.0; }
  /// At rest at the path's end.
  [[nodiscard]] bool Done() const noexcept;
  /// Time that the whole path takes when nothing brakes it [s].
  [[nodiscard]] double duration() const noexcept { return duration_; }
  /// Time until s is passed when nothing brakes it [s].
  [[nodiscard]] double TimeAt(double s) const noexcept;

 private:
  static constexpr int kGrid =
      50;  ///< Intervals at whose ends bounds are evaluated; a multiple of the spans.

  // Largest rate ds/dt at s from which the motion can still keep every bound to the end.
  [[nodiscard]] double RateBound(double s) const noexcept;

  RigPath path_;
  double s_{0.0};
  double rate_{0.0};          ///< ds/dt [1/s].
  double acceleration_{0.0};  ///< Bound on |d²s/dt²| [1/s²].
  double duration_{0.0};
  std::array<double, kGrid + 1> rate2_{};  ///< Square of RateBound() at the grid's points.
  std::array<double, kGrid + 1> time_{};   ///< TimeAt() there.
};

}  // namespace vantage
