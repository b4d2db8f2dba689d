#include "vantage/features/pixel_feature.h"

#include <cassert>
#include <cmath>

#include "feature_forms.h"

namespace vantage {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

// Image points nearer than this have no direction between them (normalised units): a tenth of a
// millionth of a pixel for any usual lens, far below what a detector resolves.
constexpr double kCoincident = 1e-9;

// Anisotropy of a set of points, relative to its size, below which it has no orientation.
constexpr double kIsotropic = 1e-9;

// x^n for the small n >= 0 of moments.
double Power(double x, int n) noexcept {
  double y = 1.0;
  for (int i = 0; i < n; ++i) y *= x;
  return y;
}

// The monomial x^p y^q.
struct Monomial {
  int p, q;

  [[nodiscard]] double Value(const Vector2d& d) const noexcept {
    return Power(d.x(), p) * Power(d.y(), q);
  }
  [[nodiscard]] Vector2d Gradient(const Vector2d& d) const noexcept {
    return {p == 0 ? 0.0 : p * Power(d.x(), p - 1) * Power(d.y(), q),
            q == 0 ? 0.0 : q * Power(d.x(), p) * Power(d.y(), q - 1)};
  }
  [[nodiscard]] Matrix2d Hessian(const Vector2d& d) const noexcept {
    Matrix2d H;
    H(0, 0) = p < 2 ? 0.0 : p * (p - 1) * Power(d.x(), p - 2) * Power(d.y(), q);
    H(1, 1) = q < 2 ? 0.0 : q * (q - 1) * Power(d.x(), p) * Power(d.y(), q - 2);
    H(0, 1) = p < 1 || q < 1 ? 0.0 : p * q * Power(d.x(), p - 1) * Power(d.y(), q - 1);
    H(1, 0) = H(0, 1);
    return H;
  }
};

Vector2d CentroidOf(const std::vector<int>& points, const PixelArray& pixels) noexcept {
  Vector2d sum = Vector2d::Zero();
  for (const int i : points) sum += pixels[i];
  return sum / static_cast<double>(points.size());
}

// Sum of a monomial over points, from an origin that is their centroid or fixed at 0.
struct MomentSum {
  Monomial monomial;
  bool centred;

  [[nodiscard]] Vector2d Origin(const std::vector<int>& points,
                                const PixelArray& pixels) const noexcept {
    return centred ? CentroidOf(points, pixels) : Vector2d(0.0, 0.0);
  }

  [[nodiscard]] double Value(const std::vector<int>& points,
                             const PixelArray& pixels) const noexcept {
    const Vector2d origin = Origin(points, pixels);
    double sum = 0.0;
    for (const int i : points) sum += monomial.Value(pixels[i] - origin);
    return sum;
  }

  // Adds factor · ∂/∂(pixel of the k-th point) to gradient[k].
  void AddGradient(const std::vector<int>& points, const PixelArray& pixels, double factor,
                   PixelRow* row) const noexcept {
    const Vector2d origin = Origin(points, pixels);
    Vector2d mean = Vector2d::Zero();  // of what moving the origin does
    if (centred) {
      for (const int i : points) mean += monomial.Gradient(pixels[i] - origin);
      mean /= static_cast<double>(points.size());
    }
    for (std::size_t k = 0; k < points.size(); ++k) {
      row->gradient[k] += factor * (monomial.Gradient(pixels[points[k]] - origin) - mean);
    }
  }

  void AddHessian(const std::vector<int>& points, const PixelArray& pixels, double factor,
                  MatrixXd* H) const {
    const Vector2d origin = Origin(points, pixels);
    const double share = centred ? 1.0 / static_cast<double>(points.size()) : 0.0;
    Matrix2d sum = Matrix2d::Zero();
    for (const int i : points) sum += monomial.Hessian(pixels[i] - origin);
    for (const int k : points) {
      const Matrix2d at_k = monomial.Hessian(pixels[k] - origin);
      H->block<2, 2>(2 * k, 2 * k) += factor * at_k;
      if (!centred) continue;
      for (const int l : points) {
        const Matrix2d at_l = monomial.Hessian(pixels[l] - origin);
        H->block<2, 2>(2 * k, 2 * l) += factor * share * (share * sum - at_k - at_l);
      }
    }
  }
};

MomentSum SumOf(const Feature& feature) noexcept {
  return {{feature.order_x, feature.order_y}, feature.kind == FeatureKind::kMomentCentred};
}

// The second order sums of a MomentVector.
constexpr std::array<Monomial, 3> kSecondOrder{{{2, 0}, {1, 1}, {0, 2}}};

bool Coincide(const Vector2d& a, const Vector2d& b, double focal) noexcept {
  return !((a - b).norm() > kCoincident * focal);
}

double Cross(const Vector2d& a, const Vector2d& b) noexcept {
  return a.x() * b.y() - a.y() * b.x();
}

// ∂angle/∂edge.
Vector2d AngleGradient(const Vector2d& edge) noexcept {
  return Vector2d(-edge.y(), edge.x()) / edge.squaredNorm();
}

void EvaluateArea(const std::vector<int>& p, const PixelArray& pixels, PixelRow* row) noexcept {
  // Relative to the first corner: the products of far-off pixels would cancel.
  const std::size_t count = p.size();
  const Vector2d origin = pixels[p[0]];
  row->value = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d previous = pixels[p[(i + count - 1) % count]] - origin;
    const Vector2d here = pixels[p[i]] - origin;
    const Vector2d next = pixels[p[(i + 1) % count]] - origin;
    row->value += 0.5 * Cross(here, next);
    row->gradient[i] = 0.5 * Vector2d(next.y() - previous.y(), previous.x() - next.x());
  }
}

void EvaluateMean(const std::vector<int>& p, const PixelArray& pixels, int axis,
                  PixelRow* row) noexcept {
  const double share = 1.0 / static_cast<double>(p.size());
  row->value = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    row->value += share * pixels[p[i]](axis);
    row->gradient[i] = share * Vector2d::Unit(axis);
  }
}

RowStatus EvaluateEdgeAngle(const std::vector<int>& p, const PixelArray& pixels, double focal,
                            PixelRow* row) noexcept {
  if (Coincide(pixels[p[0]], pixels[p[1]], focal) || Coincide(pixels[p[2]], pixels[p[3]], focal)) {
    return RowStatus::kCoincident;
  }
  const Vector2d a = pixels[p[1]] - pixels[p[0]];
  const Vector2d b = pixels[p[3]] - pixels[p[2]];
  row->value = std::atan2(Cross(a, b), a.dot(b));
  row->gradient[1] = -AngleGradient(a);
  row->gradient[0] = -row->gradient[1];
  row->gradient[3] = AngleGradient(b);
  row->gradient[2] = -row->gradient[3];
  return RowStatus::kOk;
}

RowStatus EvaluatePair(FeatureKind kind, const std::vector<int>& p, const PixelArray& pixels,
                       double focal, PixelRow* row) noexcept {
  const Vector2d& i = pixels[p[0]];
  const Vector2d& j = pixels[p[1]];
  const Vector2d e = j - i;
  if (Coincide(i, j, focal)) return RowStatus::kCoincident;
  // The two that servos use most, without their second derivatives.
  if (kind == FeatureKind::kDistance) {
    row->value = e.norm();
    row->gradient[1] = e / row->value;
    row->gradient[0] = -row->gradient[1];
    return RowStatus::kOk;
  }
  if (kind == FeatureKind::kAngle) {
    row->value = std::atan2(e.y(), e.x());
    row->gradient[1] = AngleGradient(e);
    row->gradient[0] = -row->gradient[1];
    return RowStatus::kOk;
  }
  const PairJet form = PairForm(kind, e, 0.5 * (i + j));
  row->value = form.v;
  row->gradient[0] = 0.5 * form.g.tail<2>() - form.g.head<2>();
  row->gradient[1] = 0.5 * form.g.tail<2>() + form.g.head<2>();
  return RowStatus::kOk;
}

RowStatus EvaluateMoment(const Feature& feature, const PixelArray& pixels, double focal,
                         PixelRow* row) noexcept {
  const std::vector<int>& p = feature.points;
  for (std::size_t i = 0; i < p.size(); ++i) row->gradient[i].setZero();
  if (!IsMadeOfMoments(feature.kind)) {
    const MomentSum sum = SumOf(feature);
    row->value = sum.Value(p, pixels);
    sum.AddGradient(p, pixels, 1.0, row);
    return RowStatus::kOk;
  }
  const MomentVector moments = MomentsOf(p, pixels);
  const RowStatus status = CheckMoments(feature.kind, moments, focal, p.size());
  if (status != RowStatus::kOk) return status;
  const MomentJet form = MomentForm(feature, moments);
  row->value = form.v;
  const Vector2d by_centre = form.g.head<2>() / static_cast<double>(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) row->gradient[i] = by_centre;
  for (int m = 0; m < 3; ++m) {
    if (form.g(2 + m) != 0.0) {
      MomentSum{kSecondOrder[m], true}.AddGradient(p, pixels, form.g(2 + m), row);
    }
  }
  return RowStatus::kOk;
}

// Second derivative by the pixels (u_0, v_0, ...) of a function of linear combinations of them: rows of B
// are the combinations' coefficients, h is the second derivative by the combinations.
MatrixXd Congruent(const MatrixXd& h, const MatrixXd& B) {
  return B.transpose() * h * B;
}

// Adds the coefficients of factor · pixel i to two rows of B.
void AddPixel(int row, int point, double factor, MatrixXd* B) {
  B->block<2, 2>(row, 2 * point) += factor * Matrix2d::Identity();
}

MatrixXd PairHessian(const Feature& feature, const PixelArray& pixels, int num_points) {
  const int i = feature.points[0];
  const int j = feature.points[1];
  const PairJet form = PairForm(feature.kind, pixels[j] - pixels[i], 0.5 * (pixels[i] + pixels[j]));
  MatrixXd B = MatrixXd::Zero(4, 2 * num_points);
  AddPixel(0, j, 1.0, &B);
  AddPixel(0, i, -1.0, &B);
  AddPixel(2, i, 0.5, &B);
  AddPixel(2, j, 0.5, &B);
  return Congruent(form.h, B);
}

MatrixXd EdgeAngleHessian(const Feature& feature, const PixelArray& pixels, int num_points) {
  const std::vector<int>& p = feature.points;
  MatrixXd H = MatrixXd::Zero(2 * num_points, 2 * num_points);
  for (const int edge : {0, 1}) {
    const Feature angle{FeatureKind::kAngle, {p[2 * edge], p[2 * edge + 1]}};
    H += (edge == 0 ? -1.0 : 1.0) * PairHessian(angle, pixels, num_points);
  }
  return H;
}

MatrixXd AreaHessian(const std::vector<int>& p, int num_points) {
  MatrixXd H = MatrixXd::Zero(2 * num_points, 2 * num_points);
  for (std::size_t k = 0; k < p.size(); ++k) {
    const int a = 2 * p[k];
    const int b = 2 * p[(k + 1) % p.size()];
    H(a, b + 1) += 0.5;
    H(b + 1, a) += 0.5;
    H(b, a + 1) -= 0.5;
    H(a + 1, b) -= 0.5;
  }
  return H;
}

MatrixXd MomentHessian(const Feature& feature, const PixelArray& pixels, int num_points) {
  const std::vector<int>& p = feature.points;
  MatrixXd H = MatrixXd::Zero(2 * num_points, 2 * num_points);
  if (!IsMadeOfMoments(feature.kind)) {
    SumOf(feature).AddHessian(p, pixels, 1.0, &H);
    return H;
  }
  const MomentJet form = MomentForm(feature, MomentsOf(p, pixels));
  // First derivatives of the moments by the pixels.
  MatrixXd B = MatrixXd::Zero(5, 2 * num_points);
  for (const int i : p) AddPixel(0, i, 1.0 / static_cast<double>(p.size()), &B);
  for (int m = 0; m < 3; ++m) {
    const MomentSum sum{kSecondOrder[m], true};
    PixelRow row;
    for (std::size_t k = 0; k < p.size(); ++k) row.gradient[k].setZero();
    sum.AddGradient(p, pixels, 1.0, &row);
    for (std::size_t k = 0; k < p.size(); ++k) {
      B.block<1, 2>(2 + m, 2 * p[k]) += row.gradient[k].transpose();
    }
    sum.AddHessian(p, pixels, form.g(2 + m), &H);
  }
  return H + Congruent(form.h, B);
}

bool IsLinear(const Feature& feature) noexcept {
  switch (feature.kind) {
    case FeatureKind::kPointX:
    case FeatureKind::kPointY:
    case FeatureKind::kCentroidX:
    case FeatureKind::kCentroidY:
    case FeatureKind::kSegmentX:
    case FeatureKind::kSegmentY:
    case FeatureKind::kMomentX:
    case FeatureKind::kMomentY:
      return true;
    case FeatureKind::kMomentBasic:
      return feature.order_x + feature.order_y == 1;
    default:
      return false;
  }
}

}  // namespace

PairJet PairForm(FeatureKind kind, const Vector2d& e, const Vector2d& c) noexcept {
  const PairJet ex = PairJet::Variable(e.x(), 0);
  const PairJet ey = PairJet::Variable(e.y(), 1);
  const PairJet cx = PairJet::Variable(c.x(), 2);
  const PairJet cy = PairJet::Variable(c.y(), 3);
  switch (kind) {
    case FeatureKind::kSegmentX:
      return cx;
    case FeatureKind::kSegmentY:
      return cy;
    case FeatureKind::kAngle:
    case FeatureKind::kSegmentAngle:
      return Atan2(ey, ex);
    default:
      break;
  }
  const PairJet length = Sqrt(ex * ex + ey * ey);
  switch (kind) {
    case FeatureKind::kSegmentXNormalised:
      return cx * Inverse(length);
    case FeatureKind::kSegmentYNormalised:
      return cy * Inverse(length);
    case FeatureKind::kSegmentInverseLength:
      return Inverse(length);
    default:
      assert(kind == FeatureKind::kDistance || kind == FeatureKind::kSegmentLength);
      return length;
  }
}

MomentVector MomentsOf(const std::vector<int>& points, const PixelArray& pixels) noexcept {
  MomentVector moments;
  moments.head<2>() = CentroidOf(points, pixels);
  for (int m = 0; m < 3; ++m) {
    moments(2 + m) = MomentSum{kSecondOrder[m], true}.Value(points, pixels);
  }
  return moments;
}

RowStatus CheckMoments(FeatureKind kind, const MomentVector& moments, double focal,
                       std::size_t count) noexcept {
  if (kind == FeatureKind::kMomentX || kind == FeatureKind::kMomentY ||
      kind == FeatureKind::kMomentArea) {
    return RowStatus::kOk;  // polynomials of the pixels
  }
  const double area = moments(2) + moments(4);
  const double least = kCoincident * focal;
  if (!(area > least * least * static_cast<double>(count))) return RowStatus::kCoincident;
  if (kind == FeatureKind::kMomentAlpha) {
    const double anisotropy = std::hypot(2.0 * moments(3), moments(2) - moments(4));
    if (!(anisotropy > kIsotropic * area)) return RowStatus::kUndefined;
  }
  return RowStatus::kOk;
}

MomentJet MomentForm(const Feature& feature, const MomentVector& moments) noexcept {
  const MomentJet x = MomentJet::Variable(moments(0), 0);
  const MomentJet y = MomentJet::Variable(moments(1), 1);
  const MomentJet mu20 = MomentJet::Variable(moments(2), 2);
  const MomentJet mu11 = MomentJet::Variable(moments(3), 3);
  const MomentJet mu02 = MomentJet::Variable(moments(4), 4);
  switch (feature.kind) {
    case FeatureKind::kMomentX:
      return x;
    case FeatureKind::kMomentY:
      return y;
    case FeatureKind::kMomentArea:
      return mu20 + mu02;
    case FeatureKind::kMomentAlpha:
      return 0.5 * Atan2(2.0 * mu11, mu20 - mu02);
    default:
      break;
  }
  const MomentJet normalised =
      feature.desired_depth * Sqrt(feature.desired_area * Inverse(mu20 + mu02));
  if (feature.kind == FeatureKind::kMomentXNormalised) return normalised * x;
  if (feature.kind == FeatureKind::kMomentYNormalised) return normalised * y;
  assert(feature.kind == FeatureKind::kMomentAreaNormalised);
  return normalised;
}

RowStatus EvaluatePixels(const Feature& feature, const PixelArray& pixels, double focal,
                         PixelRow* row) noexcept {
  const std::vector<int>& p = feature.points;
  switch (feature.kind) {
    case FeatureKind::kPointX:
    case FeatureKind::kPointY: {
      const int axis = feature.kind == FeatureKind::kPointX ? 0 : 1;
      row->value = pixels[p[0]](axis);
      row->gradient[0] = Vector2d::Unit(axis);
      return RowStatus::kOk;
    }
    case FeatureKind::kEdgeAngle:
      return EvaluateEdgeAngle(p, pixels, focal, row);
    case FeatureKind::kArea:
      EvaluateArea(p, pixels, row);
      return RowStatus::kOk;
    case FeatureKind::kCentroidX:
    case FeatureKind::kCentroidY:
      EvaluateMean(p, pixels, feature.kind == FeatureKind::kCentroidX ? 0 : 1, row);
      return RowStatus::kOk;
    default:
      return IsPair(feature.kind) ? EvaluatePair(feature.kind, p, pixels, focal, row)
                                  : EvaluateMoment(feature, pixels, focal, row);
  }
}

Eigen::MatrixXd PixelHessian(const Feature& feature, const PixelArray& pixels, int num_points) {
  if (IsLinear(feature)) return {};
  if (feature.kind == FeatureKind::kEdgeAngle) return EdgeAngleHessian(feature, pixels, num_points);
  if (feature.kind == FeatureKind::kArea) return AreaHessian(feature.points, num_points);
  return IsPair(feature.kind) ? PairHessian(feature, pixels, num_points)
                              : MomentHessian(feature, pixels, num_points);
}

double PrincipalPointShare(const Feature& feature, const CameraModel& camera) noexcept {
  switch (feature.kind) {
    case FeatureKind::kPointX:
    case FeatureKind::kCentroidX:
    case FeatureKind::kSegmentX:
    case FeatureKind::kMomentX:
      return camera.u0;
    case FeatureKind::kPointY:
    case FeatureKind::kCentroidY:
    case FeatureKind::kSegmentY:
    case FeatureKind::kMomentY:
      return camera.v0;
    default:
      return 0.0;
  }
}

}  // namespace vantage
