#include "vantage/features/feature_set.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "vantage/math/error.h"
#include "vantage/math/spatial.h"
#include "visp_interaction.h"

namespace vantage {
namespace {

using Eigen::Vector2d;
using PointMatrix = Eigen::Matrix<double, 2, 6>;

// Image points nearer than this have no direction between them (normalised units): a tenth of a
// millionth of a pixel for any usual lens, far below what a detector resolves.
constexpr double kCoincident = 1e-9;

struct PointCount {
  std::size_t least, most;
};

PointCount PointsOf(FeatureKind kind) noexcept {
  constexpr std::size_t kAny = static_cast<std::size_t>(kMaxPoints);
  switch (kind) {
    case FeatureKind::kPointX:
    case FeatureKind::kPointY:
      return {1, 1};
    case FeatureKind::kDistance:
    case FeatureKind::kAngle:
      return {2, 2};
    case FeatureKind::kEdgeAngle:
      return {4, 4};
    case FeatureKind::kArea:
      return {3, kAny};
    case FeatureKind::kCentroidX:
    case FeatureKind::kCentroidY:
      return {1, kAny};
  }
  return {1, 0};  // not a kind: no number of points fits
}

std::string Key(std::size_t row) {
  return "features[" + std::to_string(row) + "]";
}

void CheckEdge(std::size_t row, int i, int j) {
  if (i == j) {
    throw ConfigError("", Key(row),
                      "needs two different points, has " + std::to_string(i) + " twice");
  }
}

void CheckFeature(std::size_t row, const Feature& feature, int num_points) {
  const auto [least, most] = PointsOf(feature.kind);
  const std::size_t count = feature.points.size();
  if (count < least || count > most) {
    throw ConfigError("", Key(row),
                      "must name " + std::to_string(least) +
                          (most == least ? "" : " to " + std::to_string(most)) + " points, names " +
                          std::to_string(count));
  }
  for (const int point : feature.points) {
    if (point < 0 || point >= num_points) {
      throw ConfigError("", Key(row),
                        "names point " + std::to_string(point) + ", there are points 0 to " +
                            std::to_string(num_points - 1));
    }
  }
  const std::vector<int>& p = feature.points;
  if (feature.kind == FeatureKind::kDistance || feature.kind == FeatureKind::kAngle) {
    CheckEdge(row, p[0], p[1]);
  } else if (feature.kind == FeatureKind::kEdgeAngle) {
    CheckEdge(row, p[0], p[1]);
    CheckEdge(row, p[2], p[3]);
  }
}

bool Usable(const PointView& point) noexcept {
  return point.visible && point.image.n.allFinite() && std::isfinite(point.image.depth) &&
         point.image.depth >= kMinDepth;
}

// The image points of one call: pixels of all, interaction matrices of those that rows need.
class Points {
 public:
  Points(const CameraModel& camera, const PointViews& views)
      : views_(views), K_(CalibrationJacobian(camera)), centre_(camera.u0, camera.v0) {
    for (std::size_t i = 0; i < views.size(); ++i) usable_[i] = Usable(views[i]);
  }

  [[nodiscard]] bool AllUsable(const std::vector<int>& points) const noexcept {
    return std::all_of(points.begin(), points.end(), [&](int i) { return usable_[i]; });
  }

  [[nodiscard]] bool Coincide(int i, int j) const noexcept {
    return (views_[i].image.n - views_[j].image.n).norm() <= kCoincident;
  }

  /// Undistorted pixel of point i, from the principal point [px]: differences lose no digits to it.
  [[nodiscard]] Vector2d FromCentre(int i) const noexcept { return K_ * views_[i].image.n; }

  [[nodiscard]] Vector2d Pixel(int i) const noexcept { return FromCentre(i) + centre_; }

  [[nodiscard]] bool on_body(int i) const noexcept { return views_[i].on_body; }

  /// 2×6 interaction matrix of the pixel of point i. Asks ViSP once a point.
  [[nodiscard]] const PointMatrix& Interaction(int i) {
    if (!known_[i]) {
      L_[i] = K_ * VispPointInteraction(views_[i].image);
      known_[i] = true;
    }
    return L_[i];
  }

 private:
  const PointViews& views_;
  const Eigen::Matrix2d K_;
  const Vector2d centre_;
  std::array<bool, kMaxPoints> usable_{};
  std::array<bool, kMaxPoints> known_{};
  std::array<PointMatrix, kMaxPoints> L_;
};

// One row: its value, and its derivative by the chain rule over the points.
struct Row {
  double value{0.0};
  Twist L{Twist::Zero()};       // of all its points
  Twist L_body{Twist::Zero()};  // of those on the end effector

  // Adds the share of point i, whose pixel the value depends on with the given gradient.
  void Add(Points* points, int i, const Vector2d& gradient) {
    const Twist share = points->Interaction(i).transpose() * gradient;
    L += share;
    if (points->on_body(i)) L_body += share;
  }
};

// Adds ±∂angle/∂pixel of the line i->j.
void AddLineAngle(Points* points, int i, int j, double sign, Row* row) {
  const Vector2d d = points->FromCentre(j) - points->FromCentre(i);
  const Vector2d g = sign / d.squaredNorm() * Vector2d(-d.y(), d.x());
  row->Add(points, j, g);
  row->Add(points, i, -g);
}

// False when the value has no derivative here.
bool EvaluateRow(const Feature& feature, Points* points, Row* row) {
  const std::vector<int>& p = feature.points;
  switch (feature.kind) {
    case FeatureKind::kPointX:
    case FeatureKind::kPointY: {
      const int axis = feature.kind == FeatureKind::kPointX ? 0 : 1;
      row->value = points->Pixel(p[0])(axis);
      row->Add(points, p[0], Vector2d::Unit(axis));
      return true;
    }
    case FeatureKind::kDistance: {
      if (points->Coincide(p[0], p[1])) return false;
      const Vector2d d = points->FromCentre(p[1]) - points->FromCentre(p[0]);
      row->value = d.norm();
      const Vector2d g = d / row->value;
      row->Add(points, p[1], g);
      row->Add(points, p[0], -g);
      return true;
    }
    case FeatureKind::kAngle: {
      if (points->Coincide(p[0], p[1])) return false;
      const Vector2d d = points->FromCentre(p[1]) - points->FromCentre(p[0]);
      row->value = std::atan2(d.y(), d.x());
      AddLineAngle(points, p[0], p[1], 1.0, row);
      return true;
    }
    case FeatureKind::kEdgeAngle: {
      if (points->Coincide(p[0], p[1]) || points->Coincide(p[2], p[3])) return false;
      const Vector2d a = points->FromCentre(p[1]) - points->FromCentre(p[0]);
      const Vector2d b = points->FromCentre(p[3]) - points->FromCentre(p[2]);
      row->value = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
      AddLineAngle(points, p[0], p[1], -1.0, row);
      AddLineAngle(points, p[2], p[3], 1.0, row);
      return true;
    }
    case FeatureKind::kArea: {
      // Relative to the first corner: the products of far-off pixels would cancel.
      const std::size_t count = p.size();
      const Vector2d origin = points->FromCentre(p[0]);
      for (std::size_t i = 0; i < count; ++i) {
        const Vector2d previous = points->FromCentre(p[(i + count - 1) % count]) - origin;
        const Vector2d here = points->FromCentre(p[i]) - origin;
        const Vector2d next = points->FromCentre(p[(i + 1) % count]) - origin;
        row->value += 0.5 * (here.x() * next.y() - next.x() * here.y());
        row->Add(points, p[i], 0.5 * Vector2d(next.y() - previous.y(), previous.x() - next.x()));
      }
      return true;
    }
    case FeatureKind::kCentroidX:
    case FeatureKind::kCentroidY: {
      const int axis = feature.kind == FeatureKind::kCentroidX ? 0 : 1;
      const double share = 1.0 / static_cast<double>(p.size());
      for (const int i : p) {
        row->value += share * points->Pixel(i)(axis);
        row->Add(points, i, share * Vector2d::Unit(axis));
      }
      return true;
    }
  }
  return false;
}

bool IsAngle(FeatureKind kind) noexcept {
  return kind == FeatureKind::kAngle || kind == FeatureKind::kEdgeAngle;
}

// Into (-π, π].
double Wrap(double angle) noexcept {
  constexpr double kPi = 3.14159265358979323846;
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

// Twist of the camera, in its own axes, that the points would see as the motion V_WE_W of a body: the
// camera fixed to the body would move by it.
Matrix6d CameraOnBody(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_WE) noexcept {
  const Eigen::Matrix3d R_CW = X_WC.linear().transpose();
  Matrix6d Ad;
  Ad.topLeftCorner<3, 3>() = R_CW;
  Ad.topRightCorner<3, 3>() = R_CW * Skew(p_WE - X_WC.translation());
  Ad.bottomLeftCorner<3, 3>().setZero();
  Ad.bottomRightCorner<3, 3>() = R_CW;
  return Ad;
}

}  // namespace

FeatureSet::FeatureSet(std::vector<Feature> features, int num_points)
    : features_(std::move(features)), num_points_(num_points) {
  if (num_points < 1 || num_points > kMaxPoints) {
    throw ConfigError("", "points",
                      "there must be 1 to " + std::to_string(kMaxPoints) + ", there are " +
                          std::to_string(num_points));
  }
  if (features_.empty() || features_.size() > static_cast<std::size_t>(kMaxRows)) {
    throw ConfigError("", "features",
                      "must be 1 to " + std::to_string(kMaxRows) + " rows, are " +
                          std::to_string(features_.size()));
  }
  for (std::size_t i = 0; i < features_.size(); ++i) CheckFeature(i, features_[i], num_points);
}

FeatureSet FeatureSet::AllPoints(int num_points) {
  std::vector<Feature> features;
  for (int i = 0; i < num_points; ++i) {
    features.push_back({FeatureKind::kPointX, {i}});
    features.push_back({FeatureKind::kPointY, {i}});
  }
  return FeatureSet(std::move(features), num_points);
}

void FeatureSet::Evaluate(const CameraModel& camera, const PointViews& points,
                          FeatureRows* rows) const {
  assert(static_cast<int>(points.size()) == num_points_);
  Points image(camera, points);
  const auto most = static_cast<Eigen::Index>(features_.size());
  rows->s.resize(most);
  rows->L.resize(most, 6);
  rows->L_body.resize(most, 6);
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    Row row;
    if (!image.AllUsable(features_[i].points) || !EvaluateRow(features_[i], &image, &row)) continue;
    rows->s(count) = row.value;
    rows->L.row(count) = row.L;
    rows->L_body.row(count) = row.L_body;
    rows->feature[count] = static_cast<int>(i);
    ++count;
  }
  // Storage is column-major and inside the object: shrinking by copy, never by the heap.
  rows->s.conservativeResize(count);
  rows->L.conservativeResize(count, 6);
  rows->L_body.conservativeResize(count, 6);
}

FeatureJacobian ImageJacobian(const FeatureJacobian& L_body, const Eigen::Isometry3d& X_WC,
                              const Eigen::Vector3d& p_WE) noexcept {
  // The points move and the camera stands: to them that is the camera moving the other way.
  return -L_body * CameraOnBody(X_WC, p_WE);
}

FeatureJacobian ImageJacobianEyeInHand(const FeatureRows& rows, const Eigen::Isometry3d& X_WC,
                                       const Eigen::Vector3d& p_WE) noexcept {
  // Points on the end effector stand still before a camera on it.
  return (rows.L - rows.L_body) * CameraOnBody(X_WC, p_WE);
}

FeatureVector FeatureError(const FeatureSet& set, const FeatureRows& current,
                           const FeatureRows& goal) noexcept {
  assert(current.size() == goal.size());
  FeatureVector error = current.s - goal.s;
  for (int i = 0; i < current.size(); ++i) {
    assert(current.feature[i] == goal.feature[i]);
    if (IsAngle(set.features()[current.feature[i]].kind)) error(i) = Wrap(error(i));
  }
  return error;
}

}  // namespace vantage
