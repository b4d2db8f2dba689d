#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "batch_data.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/observability/batch.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

template <class T>
void Copy(const Vector3d& from, T (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<T>(from(i));
}

template <class T>
batch::CapsuleTest<T> MakeTest(const Vector3d& P, const BatchCapsule& capsule, double unit) {
  const Vector3d axis = capsule.p_WB - capsule.p_WA;
  const double length = axis.norm();
  // The axis of a ball is a point: any direction does, with no room along it.
  const Vector3d u = length > 0.0 ? Vector3d(axis / length) : Vector3d::UnitX();
  const Vector3d from_A = P - capsule.p_WA;
  const double along = u.dot(from_A);
  const Vector3d e = from_A - along * u;
  batch::CapsuleTest<T> test{};
  Copy(u, test.u);
  Copy(Vector3d(e / unit), test.e);
  test.e2 = static_cast<T>(e.squaredNorm() / (unit * unit));
  test.before = static_cast<T>(-along / unit);
  test.after = static_cast<T>((length - along) / unit);
  test.half_radius = static_cast<T>(0.5 * capsule.radius / unit);
  test.half_inverse = static_cast<T>(0.5 * unit / capsule.radius);
  return test;
}

template <class T>
void PackObstacles(const std::vector<BatchSight>& sights, const std::vector<BatchBox>& boxes,
                   double max_incidence, const Vector3d& origin, double unit,
                   batch::PackedObstacles<T>* out) {
  for (const BatchSight& s : sights) {
    batch::Sight<T> sight{};
    Copy(Vector3d((s.p_W - origin) / unit), sight.p);
    Copy(s.normal_W, sight.normal);
    sight.first_capsule = static_cast<int>(out->capsule.size());
    sight.capsules = static_cast<int>(s.capsules.size());
    for (const BatchCapsule& capsule : s.capsules) {
      out->capsule.push_back(MakeTest<T>(s.p_W, capsule, unit));
    }
    out->sight.push_back(sight);
  }
  for (const BatchBox& b : boxes) {
    batch::BoxTest<T> box{};
    for (int i = 0; i < 9; ++i) box.b[i] = static_cast<T>(b.X_WB.linear()(i % 3, i / 3));
    Copy(Vector3d((b.X_WB.translation() - origin) / unit), box.centre);
    Copy(Vector3d(b.half / unit), box.half);
    out->box.push_back(box);
  }
  out->view.sight = out->sight.data();
  out->view.sights = static_cast<int>(out->sight.size());
  out->view.capsule = out->capsule.data();
  out->view.box = out->box.data();
  out->view.boxes = static_cast<int>(out->box.size());
  out->view.facing = max_incidence < kPi;
  out->view.min_cosine = static_cast<T>(std::cos(std::min(max_incidence, kPi)));
}

}  // namespace

BatchObstacles::BatchObstacles(std::vector<BatchSight> sights, std::vector<BatchBox> boxes,
                               double max_incidence, double unit) {
  if (boxes.size() > batch::kMaxBatchBoxes) {
    throw ConfigError("", "batch.boxes",
                      "must be " + std::to_string(batch::kMaxBatchBoxes) + " at most, are " +
                          std::to_string(boxes.size()));
  }
  if (!(unit > 0.0) || !std::isfinite(unit)) {
    throw ConfigError("", "batch.unit", "must be > 0 m, is " + std::to_string(unit));
  }
  for (const BatchSight& s : sights) {
    for (const BatchCapsule& c : s.capsules) {
      if (!(c.radius > 0.0)) {
        throw ConfigError("", "batch.capsules",
                          "must have a radius > 0 m, one has " + std::to_string(c.radius));
      }
    }
  }
  auto data = std::make_unique<Data>();
  if (!sights.empty()) data->origin = sights[sights.size() / 2].p_W;
  data->unit = unit;
  PackObstacles(sights, boxes, max_incidence, Vector3d::Zero(), 1.0, &data->f64);
  PackObstacles(sights, boxes, max_incidence, data->origin, unit, &data->f32);
  data_ = std::move(data);
}

BatchObstacles::~BatchObstacles() = default;
BatchObstacles::BatchObstacles(BatchObstacles&&) noexcept = default;
BatchObstacles& BatchObstacles::operator=(BatchObstacles&&) noexcept = default;

}  // namespace vantage
