#include "vantage/features/feature_set.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/QR>

#include "feature_forms.h"
#include "vantage/features/pixel_feature.h"
#include "vantage/features/point_feature.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"
#include "visp_interaction.h"

namespace vantage {
namespace {

using Eigen::Vector2d;
using PointMatrix = Eigen::Matrix<double, 2, 6>;

std::string Key(std::size_t row) {
  return "features[" + std::to_string(row) + "]";
}

void CheckEdge(std::size_t row, int i, int j) {
  if (i == j) {
    throw ConfigError("", Key(row),
                      "needs two different points, has " + std::to_string(i) + " twice");
  }
}

void CheckMoment(std::size_t row, const Feature& feature) {
  const bool centred = feature.kind == FeatureKind::kMomentCentred;
  if (centred || feature.kind == FeatureKind::kMomentBasic) {
    const int p = feature.order_x;
    const int q = feature.order_y;
    const int least = centred ? 2 : 1;
    if (p < 0 || q < 0 || p + q < least || p + q > kMaxMomentOrder) {
      throw ConfigError("", Key(row),
                        "orders must be >= 0 and add up to " + std::to_string(least) + " to " +
                            std::to_string(kMaxMomentOrder) + ", are " + std::to_string(p) +
                            " and " + std::to_string(q));
    }
  }
  if (!(feature.desired_area > 0.0) || !std::isfinite(feature.desired_area) ||
      !(feature.desired_depth > 0.0) || !std::isfinite(feature.desired_depth)) {
    throw ConfigError("", Key(row),
                      "desired area and depth must be > 0 and finite, are " +
                          std::to_string(feature.desired_area) + " px^2 and " +
                          std::to_string(feature.desired_depth) + " m");
  }
}

void CheckFeature(std::size_t row, const Feature& feature, int num_points) {
  const auto [least, most] = PointsOf(feature.kind);
  const auto count = static_cast<int>(feature.points.size());
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
  if (IsPair(feature.kind)) {
    CheckEdge(row, p[0], p[1]);
  } else if (feature.kind == FeatureKind::kEdgeAngle) {
    CheckEdge(row, p[0], p[1]);
    CheckEdge(row, p[2], p[3]);
  }
  if (IsMoment(feature.kind)) CheckMoment(row, feature);
}

RowStatus StatusOf(const PointView& point) noexcept {
  if (!point.image.n.allFinite() || !std::isfinite(point.image.depth)) return RowStatus::kNotFinite;
  if (point.image.depth < kMinDepth) return RowStatus::kBehindCamera;
  return point.visible ? RowStatus::kOk : RowStatus::kNotSeen;
}

// μ_pq or m_pq of pixels from those of normalised coordinates, (u, v) = K (x, y) with K upper
// triangular: a polynomial of the same order.
Twist PixelMoment(const Eigen::Matrix2d& K, int p, int q,
                  const MomentInteraction::Row (&L)[kMaxMomentOrder + 1][kMaxMomentOrder + 1]) {
  Twist sum = Twist::Zero();
  double binomial = 1.0;
  for (int i = p; i >= 0; --i) {  // (K00 x + K01 y)^p term by term
    const double factor = binomial * std::pow(K(0, 0), i) * std::pow(K(0, 1), p - i);
    if (factor != 0.0) sum += factor * std::pow(K(1, 1), q) * L[i][p + q - i].transpose();
    binomial *= static_cast<double>(i) / (p - i + 1);
  }
  return sum;
}

// The image points of one call: pixels of all, interaction matrices of those that rows need.
class Points {
 public:
  Points(const CameraModel& camera, const PointViews& views, InteractionSource source)
      : camera_(camera), views_(views), source_(source), K_(CalibrationJacobian(camera)) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      status_[i] = StatusOf(views[i]);
      // From the principal point: differences lose no digits to it.
      if (status_[i] == RowStatus::kOk) pixels_[i] = K_ * views[i].image.n;
    }
  }

  /// Writes row k: the feature's value, and its derivatives by the chain rule over the points.
  /// @param gradient  False: rows->L and rows->L_body are left as they are.
  RowStatus Evaluate(const Feature& feature, bool gradient, Eigen::Index k, FeatureRows* rows) {
    for (const int i : feature.points) {
      if (status_[i] != RowStatus::kOk) return status_[i];
    }
    if (feature.kind == FeatureKind::kPointX || feature.kind == FeatureKind::kPointY) {
      const int i = feature.points[0];
      const int axis = feature.kind == FeatureKind::kPointX ? 0 : 1;
      rows->s(k) = pixels_[i](axis) + PrincipalPointShare(feature, camera_);
      if (gradient) TakeFromOneBody(feature, Interaction(i).row(axis), k, rows);
      return RowStatus::kOk;
    }
    PixelRow pixel_row;
    const RowStatus status =
        EvaluatePixels(feature, pixels_, std::min(camera_.fx, camera_.fy), &pixel_row);
    if (status != RowStatus::kOk) return status;
    rows->s(k) = pixel_row.value + PrincipalPointShare(feature, camera_);
    if (!gradient) return RowStatus::kOk;
    const bool as_visp = source_ == InteractionSource::kVisp && OnOneBody(feature);
    if (as_visp && IsSegment(feature.kind)) {
      TakeFromOneBody(feature, SegmentRow(feature).transpose(), k, rows);
    } else if (as_visp && IsMoment(feature.kind) && KnowMoments(feature.points)) {
      TakeFromOneBody(feature, MomentRow(feature).transpose(), k, rows);
    } else {
      rows->L.row(k).setZero();
      rows->L_body.row(k).setZero();
      for (std::size_t i = 0; i < feature.points.size(); ++i) {
        const int point = feature.points[i];
        const Eigen::Matrix<double, 1, 6> share =
            pixel_row.gradient[i].transpose() * Interaction(point);
        rows->L.row(k) += share;
        if (views_[point].on_body) rows->L_body.row(k) += share;
      }
    }
    return RowStatus::kOk;
  }

 private:
  /// 2×6 interaction matrix of the pixel of point i. Asked for once a point.
  const PointMatrix& Interaction(int i) {
    if (!known_[i]) {
      const ImagePoint& image = views_[i].image;
      L_[i] = K_ * (source_ == InteractionSource::kVisp ? VispPointInteraction(image)
                                                        : PointInteraction(image));
      known_[i] = true;
    }
    return L_[i];
  }

  [[nodiscard]] bool OnOneBody(const Feature& feature) const noexcept {
    const bool first = views_[feature.points[0]].on_body;
    return std::all_of(feature.points.begin(), feature.points.end(),
                       [&](int i) { return views_[i].on_body == first; });
  }

  template <typename Derived>
  void TakeFromOneBody(const Feature& feature, const Eigen::MatrixBase<Derived>& L, Eigen::Index k,
                       FeatureRows* rows) const noexcept {
    rows->L.row(k) = L;
    if (views_[feature.points[0]].on_body) {
      rows->L_body.row(k) = L;
    } else {
      rows->L_body.row(k).setZero();
    }
  }

  [[nodiscard]] Twist SegmentRow(const Feature& feature) const {
    const int i = feature.points[0];
    const int j = feature.points[1];
    const Eigen::Matrix<double, 4, 6> L =
        VispSegmentInteraction(views_[i].image, views_[j].image);  // (x_c, y_c, l, alpha)
    const Vector2d edge = views_[j].image.n - views_[i].image.n;
    const Vector2d along = edge.normalized();
    Eigen::Matrix2d by_polar;  // ∂edge/∂(l, alpha)
    by_polar << along.x(), -edge.y(), along.y(), edge.x();
    const PairJet form =
        PairForm(feature.kind, pixels_[j] - pixels_[i], 0.5 * (pixels_[i] + pixels_[j]));
    return (K_ * by_polar * L.bottomRows<2>()).transpose() * form.g.head<2>() +
           (K_ * L.topRows<2>()).transpose() * form.g.tail<2>();
  }

  // Asks ViSP for the moments of these points. False where they are not in one plane.
  bool KnowMoments(const std::vector<int>& points) {
    if (moments_of_ != nullptr && *moments_of_ == points) return true;
    const auto count = static_cast<Eigen::Index>(points.size());
    Eigen::MatrixX3d coordinates(count, 3);
    Eigen::VectorXd inverse_depth(count);
    std::vector<Vector2d> n;
    for (Eigen::Index k = 0; k < count; ++k) {
      const ImagePoint& image = views_[points[k]].image;
      coordinates.row(k) << image.n.x(), image.n.y(), 1.0;
      inverse_depth(k) = 1.0 / image.depth;
      n.push_back(image.n);
    }
    const Eigen::Vector3d plane =
        coordinates.completeOrthogonalDecomposition().solve(inverse_depth);
    const double off = (coordinates * plane - inverse_depth).cwiseAbs().maxCoeff();
    if (!(off <= kCoplanar * inverse_depth.maxCoeff())) return false;
    moments_ = VispMomentInteraction(n, {plane(0), plane(1), plane(2)});
    moments_of_ = &points;
    return true;
  }

  [[nodiscard]] Twist MomentRow(const Feature& feature) const {
    const int p = feature.order_x;
    const int q = feature.order_y;
    if (feature.kind == FeatureKind::kMomentBasic) return PixelMoment(K_, p, q, moments_.basic);
    if (feature.kind == FeatureKind::kMomentCentred) return PixelMoment(K_, p, q, moments_.centred);
    Eigen::Matrix<double, 5, 6> L;
    L.topRows<2>() = K_ * moments_.centre;
    L.row(2) = PixelMoment(K_, 2, 0, moments_.centred).transpose();
    L.row(3) = PixelMoment(K_, 1, 1, moments_.centred).transpose();
    L.row(4) = PixelMoment(K_, 0, 2, moments_.centred).transpose();
    return L.transpose() * MomentForm(feature, MomentsOf(feature.points, pixels_)).g;
  }

  // Points whose inverse depths are further than this from a plane's are not in it (relative).
  static constexpr double kCoplanar = 1e-12;

  const CameraModel& camera_;
  const PointViews& views_;
  const InteractionSource source_;
  const Eigen::Matrix2d K_;
  std::array<RowStatus, kMaxPoints> status_;
  PixelArray pixels_;
  std::array<bool, kMaxPoints> known_{};
  std::array<PointMatrix, kMaxPoints> L_;
  const std::vector<int>* moments_of_{nullptr};
  MomentInteraction moments_;
};

// Angle after which the feature is the same again; 0 for what is not an angle.
double PeriodOf(FeatureKind kind) noexcept {
  switch (kind) {
    case FeatureKind::kAngle:
    case FeatureKind::kEdgeAngle:
    case FeatureKind::kSegmentAngle:
      return 2.0 * kPi;
    case FeatureKind::kMomentAlpha:
      return kPi;
    default:
      return 0.0;
  }
}

// Into (-period/2, period/2].
double Wrap(double angle, double period) noexcept {
  const double wrapped = std::remainder(angle, period);
  return wrapped <= -0.5 * period ? 0.5 * period : wrapped;
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

const char* NameOf(RowStatus status) noexcept {
  switch (status) {
    case RowStatus::kOk:
      return "OK";
    case RowStatus::kNotSeen:
      return "NOT_SEEN";
    case RowStatus::kBehindCamera:
      return "BEHIND_CAMERA";
    case RowStatus::kNotFinite:
      return "NOT_FINITE";
    case RowStatus::kCoincident:
      return "COINCIDENT";
    case RowStatus::kUndefined:
      return "UNDEFINED";
  }
  return "?";
}

CameraModel InUnits(const CameraModel& camera, ImageUnits units, double focal_length) noexcept {
  if (units == ImageUnits::kPixels) return camera;
  CameraModel result = camera;
  result.fx = result.fy = units == ImageUnits::kNormalised ? 1.0 : focal_length;
  result.u0 = result.v0 = result.skew = 0.0;
  result.distortion = Distortion{};
  return result;
}

PointView ViewOf(const Eigen::Vector3d& p_CP, bool on_body) noexcept {
  if (const std::optional<ImagePoint> image = Project(p_CP)) return {*image, true, on_body};
  PointView view;
  view.image.depth = p_CP.allFinite() ? p_CP.z() : std::numeric_limits<double>::quiet_NaN();
  view.on_body = on_body;
  return view;
}

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

void FeatureSet::Evaluate(const CameraModel& camera, const PointViews& points, FeatureRows* rows,
                          InteractionSource source) const {
  EvaluateRows(camera, points, source, true, rows);
}

void FeatureSet::EvaluateValues(const CameraModel& camera, const PointViews& points,
                                FeatureRows* rows) const {
  EvaluateRows(camera, points, InteractionSource::kClosedForm, false, rows);
}

void FeatureSet::EvaluateRows(const CameraModel& camera, const PointViews& points,
                              InteractionSource source, bool with_gradient,
                              FeatureRows* rows) const {
  assert(static_cast<int>(points.size()) == num_points_);
  Points image(camera, points, source);
  const auto most = static_cast<Eigen::Index>(features_.size());
  rows->s.resize(most);
  rows->L.resize(with_gradient ? most : 0, 6);
  rows->L_body.resize(with_gradient ? most : 0, 6);
  rows->status.fill(RowStatus::kNotSeen);
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    rows->status[i] = image.Evaluate(features_[i], with_gradient, count, rows);
    if (rows->status[i] != RowStatus::kOk) continue;
    rows->feature[count] = static_cast<int>(i);
    ++count;
  }
  // Storage is column-major and inside the object: shrinking by copy, never by the heap.
  rows->s.conservativeResize(count);
  if (!with_gradient) return;
  rows->L.conservativeResize(count, 6);
  rows->L_body.conservativeResize(count, 6);
}

FeatureJacobian ImageJacobian(const FeatureJacobian& L_body, const Eigen::Isometry3d& X_WC,
                              const Eigen::Vector3d& p_WE) noexcept {
  // The points move and the camera stands: to them that is the camera moving the other way. The blocks
  // of CameraOnBody() one by one: half of it are zeros or the same.
  const Eigen::Matrix3d R_CW = X_WC.linear().transpose();
  FeatureJacobian J_v(L_body.rows(), 6);
  J_v.leftCols<3>() = -L_body.leftCols<3>().lazyProduct(R_CW);
  J_v.rightCols<3>() = J_v.leftCols<3>().lazyProduct(Skew(p_WE - X_WC.translation())) -
                       L_body.rightCols<3>().lazyProduct(R_CW);
  return J_v;
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
    const double period = PeriodOf(set.features()[current.feature[i]].kind);
    if (period > 0.0) error(i) = Wrap(error(i), period);
  }
  return error;
}

}  // namespace vantage
