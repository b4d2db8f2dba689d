#include "vantage/robot/capsule_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <nlopt.hpp>

#include "vantage/math/angles.h"
#include "vantage/math/segment.h"

namespace vantage {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kThinnest = 1e-4;  // Radius [m].
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The smallest capsule on the line through p along d (|d| = 1) that is `extra` wider than the widest
// point asks for. A wider one has its round ends reach further over the points, so that it is shorter.
CapsuleShape CapsuleOnLine(const std::vector<Vector3d>& points, const Vector3d& p,
                           const Vector3d& d, double extra) {
  double widest2 = 0.0;
  for (const Vector3d& x : points) {
    const Vector3d offset = x - p;
    const double t = offset.dot(d);
    widest2 = std::max(widest2, offset.squaredNorm() - t * t);
  }
  const double radius = std::max(std::sqrt(widest2) + extra, kThinnest);
  double low = kInfinity;  // Each end ball must reach its points: low <= t + h, high >= t - h.
  double high = -kInfinity;
  for (const Vector3d& x : points) {
    const Vector3d offset = x - p;
    const double t = offset.dot(d);
    const double across2 = offset.squaredNorm() - t * t;
    const double h = std::sqrt(std::max(0.0, radius * radius - across2));
    low = std::min(low, t + h);
    high = std::max(high, t - h);
  }
  if (high < low) low = high = 0.5 * (low + high);  // One ball holds them all.
  return {p + low * d, p + high * d, radius};
}

// Columns: principal axes, longest first; the centre of the bounding box along them.
struct PrincipalFrame {
  Matrix3d axes{Matrix3d::Identity()};
  Vector3d centre{Vector3d::Zero()};
  Vector3d low{Vector3d::Zero()},
      high{Vector3d::Zero()};  // Extents along the axes, from the origin.
};

PrincipalFrame FindPrincipalFrame(const std::vector<Vector3d>& points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& x : points) mean += x;
  mean /= static_cast<double>(points.size());
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& x : points) covariance += (x - mean) * (x - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  PrincipalFrame frame;
  frame.axes = solver.eigenvectors().rowwise().reverse();
  frame.low.setConstant(kInfinity);
  frame.high.setConstant(-kInfinity);
  for (const Vector3d& x : points) {
    const Vector3d along = frame.axes.transpose() * x;
    frame.low = frame.low.cwiseMin(along);
    frame.high = frame.high.cwiseMax(along);
  }
  frame.centre = frame.axes * (0.5 * (frame.low + frame.high));
  return frame;
}

// Those points that lie farthest in one of many directions: a capsule round them holds nearly all.
std::vector<Vector3d> ExtremePoints(const std::vector<Vector3d>& points) {
  constexpr int kDirections = 250;
  if (points.size() <= kDirections) return points;
  std::vector<std::size_t> chosen;
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections;
    const double r = std::sqrt(1.0 - z * z);
    const Vector3d direction(r * std::cos(golden_angle * i), r * std::sin(golden_angle * i), z);
    std::size_t best = 0;
    double farthest = -kInfinity;
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double along = direction.dot(points[j]);
      if (along > farthest) {
        farthest = along;
        best = j;
      }
    }
    chosen.push_back(best);
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  std::vector<Vector3d> extreme;
  for (const std::size_t i : chosen) extreme.push_back(points[i]);
  return extreme;
}

// Search for a line near the start's: two tilts of the axis, two shifts across it, and the extra
// radius.
class LineSearch {
 public:
  LineSearch(const std::vector<Vector3d>& points, const Vector3d& p, const Vector3d& d, double size)
      : points_(points), p_(p), d_(d), e1_(d.unitOrthogonal()), e2_(d.cross(e1_)), size_(size) {}

  // The best line and extra radius found.
  struct Result {
    Vector3d p, d;
    double extra;
    double volume{kInfinity};
  };

  Result Run() {
    nlopt::opt search(nlopt::LN_SBPLX, 5);
    search.set_min_objective(&LineSearch::Cost, this);
    search.set_initial_step({0.15, 0.15, 0.05, 0.05, 0.05});
    search.set_maxeval(700);
    search.set_ftol_rel(1e-7);
    std::vector<double> x(5, 0.0);
    double volume = 0.0;
    try {
      search.optimize(x, volume);
    } catch (const nlopt::roundoff_limited&) {
      // The best value so far is what is wanted.
    }
    return best_;
  }

 private:
  static double Cost(const std::vector<double>& x, std::vector<double>& /*gradient*/, void* self) {
    return static_cast<LineSearch*>(self)->Evaluate(x);
  }

  double Evaluate(const std::vector<double>& x) {
    Result result;
    result.d = (d_ + x[0] * e1_ + x[1] * e2_).normalized();
    result.p = p_ + size_ * (x[2] * e1_ + x[3] * e2_);
    result.extra = size_ * std::abs(x[4]);
    result.volume = Volume(CapsuleOnLine(points_, result.p, result.d, result.extra));
    if (result.volume < best_.volume) best_ = result;
    return result.volume;
  }

  const std::vector<Vector3d>& points_;
  Vector3d p_, d_, e1_, e2_;
  double size_;
  Result best_{};
};

// A quick upper bound of the volume of the capsule round some points.
double QuickVolume(const std::vector<Vector3d>& points) {
  const PrincipalFrame frame = FindPrincipalFrame(points);
  double least = kInfinity;
  for (int axis = 0; axis < 2; ++axis) {
    least = std::min(least, Volume(CapsuleOnLine(points, frame.centre, frame.axes.col(axis), 0.0)));
  }
  return least;
}

struct Plane {
  Vector3d normal;
  double offset;
  [[nodiscard]] double Above(const Vector3d& p) const { return normal.dot(p) - offset; }
};

// One side of a surface: side +1 is above the plane. Triangles that the plane crosses are clipped.
TriangleSurface Clip(const TriangleSurface& surface, const Plane& plane, double side) {
  TriangleSurface part;
  for (const auto& triangle : surface.triangles) {
    std::array<Vector3d, 4> polygon;
    std::uint32_t corners = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& a = surface.points[triangle[i]];
      const Vector3d& b = surface.points[triangle[(i + 1) % 3]];
      const double above_a = side * plane.Above(a);
      const double above_b = side * plane.Above(b);
      if (above_a >= 0.0) polygon[corners++] = a;
      if ((above_a < 0.0) != (above_b < 0.0)) {
        polygon[corners++] = a + above_a / (above_a - above_b) * (b - a);
      }
    }
    const auto first = static_cast<std::uint32_t>(part.points.size());
    if (corners < 3) continue;
    part.points.insert(part.points.end(), polygon.begin(), polygon.begin() + corners);
    for (std::uint32_t i = 2; i < corners; ++i) {
      part.triangles.push_back({first, first + i - 1, first + i});
    }
  }
  return part;
}

// The corners of both sides' clipped triangles, without the triangles. Of a large surface some only.
std::pair<std::vector<Vector3d>, std::vector<Vector3d>> SplitPoints(const TriangleSurface& surface,
                                                                    const Plane& plane) {
  constexpr std::size_t kEnough = 2000;
  const std::size_t stride = 1 + surface.triangles.size() / kEnough;
  std::pair<std::vector<Vector3d>, std::vector<Vector3d>> sides;
  for (std::size_t k = 0; k < surface.triangles.size(); k += stride) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& a = surface.points[surface.triangles[k][i]];
      const Vector3d& b = surface.points[surface.triangles[k][(i + 1) % 3]];
      const double above_a = plane.Above(a);
      const double above_b = plane.Above(b);
      (above_a >= 0.0 ? sides.second : sides.first).push_back(a);
      if ((above_a < 0.0) == (above_b < 0.0)) continue;
      const Vector3d cut = a + above_a / (above_a - above_b) * (b - a);
      sides.first.push_back(cut);
      sides.second.push_back(cut);
    }
  }
  return sides;
}

struct Part {
  TriangleSurface surface;
  CapsuleShape capsule;
};

struct Split {
  Part low, high;
  [[nodiscard]] double volume() const { return Volume(low.capsule) + Volume(high.capsule); }
};

std::optional<Split> FindSplit(const Part& part, double gain) {
  constexpr int kCutsPerAxis = 9;
  constexpr std::size_t kFullyFitted = 2;
  const PrincipalFrame frame = FindPrincipalFrame(part.surface.points);
  std::vector<std::pair<double, Plane>> cuts;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 1; i <= kCutsPerAxis; ++i) {
      const double s = static_cast<double>(i) / (kCutsPerAxis + 1);
      const Plane plane{frame.axes.col(axis),
                        frame.low[axis] + s * (frame.high[axis] - frame.low[axis])};
      const auto [low, high] = SplitPoints(part.surface, plane);
      if (low.size() < 3 || high.size() < 3) continue;
      cuts.emplace_back(QuickVolume(low) + QuickVolume(high), plane);
    }
  }
  const std::size_t fitted = std::min(kFullyFitted, cuts.size());
  std::partial_sort(cuts.begin(), cuts.begin() + static_cast<std::ptrdiff_t>(fitted), cuts.end(),
                    [](const auto& a, const auto& b) { return a.first < b.first; });
  std::optional<Split> best;
  for (std::size_t i = 0; i < fitted; ++i) {
    Split split;
    split.low.surface = Clip(part.surface, cuts[i].second, -1.0);
    split.high.surface = Clip(part.surface, cuts[i].second, 1.0);
    if (split.low.surface.triangles.empty() || split.high.surface.triangles.empty()) continue;
    split.low.capsule = FitCapsule(split.low.surface.points);
    split.high.capsule = FitCapsule(split.high.surface.points);
    if (split.volume() > gain * Volume(part.capsule)) continue;
    if (!best || split.volume() < best->volume()) best = std::move(split);
  }
  return best;
}

}  // namespace

double Volume(const CapsuleShape& capsule) noexcept {
  const double r = capsule.radius;
  return kPi * r * r * ((capsule.p_B - capsule.p_A).norm() + 4.0 / 3.0 * r);
}

bool Contains(const CapsuleShape& outer, const CapsuleShape& inner, double tolerance) noexcept {
  const double room = outer.radius - inner.radius + tolerance;
  const Vector3d axis = outer.p_B - outer.p_A;
  return std::sqrt(SquaredDistanceToSegment(inner.p_A, outer.p_A, axis)) <= room &&
         std::sqrt(SquaredDistanceToSegment(inner.p_B, outer.p_A, axis)) <= room;
}

CapsuleShape FitCapsule(const std::vector<Vector3d>& points) {
  assert(!points.empty());
  const std::vector<Vector3d> extreme = ExtremePoints(points);
  const PrincipalFrame frame = FindPrincipalFrame(extreme);
  const double size = (frame.high - frame.low).maxCoeff();
  if (!(size > 0.0)) return {points[0], points[0], kThinnest};
  CapsuleShape best;
  double least = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const LineSearch::Result line =
        LineSearch(extreme, frame.centre, frame.axes.col(axis), size).Run();
    if (line.volume >= least) continue;
    least = line.volume;
    best = CapsuleOnLine(points, line.p, line.d, line.extra);
  }
  best.radius += 1e-9 * size;  // Of rounding.
  return best;
}

CapsuleShape FitCapsuleToCylinder(double radius, double length) {
  assert(radius > 0.0 && length >= 0.0);
  // With the ends of the axis at ±a the rims ask for r = hypot(radius, length/2 - a). The volume has
  // one minimum over a in [0, length/2]: it is found by thirds.
  const double half = 0.5 * length;
  const auto capsule = [&](double a) {
    return CapsuleShape{{0.0, 0.0, -a}, {0.0, 0.0, a}, std::hypot(radius, half - a)};
  };
  double low = 0.0;
  double high = half;
  for (int i = 0; i < 100; ++i) {
    const double a = low + (high - low) / 3.0;
    const double b = high - (high - low) / 3.0;
    if (Volume(capsule(a)) < Volume(capsule(b))) {
      high = b;
    } else {
      low = a;
    }
  }
  CapsuleShape fitted = capsule(0.5 * (low + high));
  fitted.radius = std::max(fitted.radius * (1.0 + 1e-12), kThinnest);
  return fitted;
}

std::vector<CapsuleShape> FitCapsules(const TriangleSurface& surface, int max_count, double gain) {
  assert(!surface.triangles.empty() && max_count >= 1 && gain > 0.0 && gain < 1.0);
  struct Candidate {
    Part part;
    std::optional<Split> split;
  };
  const auto consider = [&](Part part, bool may_split) {
    Candidate candidate{std::move(part), std::nullopt};
    if (may_split) candidate.split = FindSplit(candidate.part, gain);
    return candidate;
  };
  std::vector<Candidate> candidates;
  candidates.push_back(consider({surface, FitCapsule(surface.points)}, max_count > 1));
  const auto saving = [](const Candidate& candidate) {
    return candidate.split ? Volume(candidate.part.capsule) - candidate.split->volume() : 0.0;
  };
  while (static_cast<int>(candidates.size()) < max_count) {
    const auto best = std::max_element(
        candidates.begin(), candidates.end(),
        [&](const Candidate& a, const Candidate& b) { return saving(a) < saving(b); });
    if (!best->split) break;
    Split split = std::move(*best->split);
    const bool more = static_cast<int>(candidates.size()) + 1 < max_count;
    *best = consider(std::move(split.low), more);
    candidates.push_back(consider(std::move(split.high), more));
  }
  std::vector<CapsuleShape> capsules;
  for (const Candidate& candidate : candidates) capsules.push_back(candidate.part.capsule);
  return capsules;
}

}  // namespace vantage
