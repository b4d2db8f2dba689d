#include "sim/render/hidden_points.h"

#include <algorithm>

#include "sim/render/vector_clones.h"

namespace vantage::sim {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

// From a body's frame to the space where a solid's ellipsoid is a unit sphere: d p + t for a point p, from the centre of
// the ellipsoid at the first end of the solid's segment.
struct UnitSpace {
  float d00, d01, d02, d10, d11, d12, d20, d21, d22, tx, ty, tz;
  float ex, ey, ez;  // The camera.
};

struct UnitPoint {
  float x, y, z;
};

inline UnitPoint ToUnit(const UnitSpace& s, float x, float y, float z) {
  return {s.d00 * x + s.d01 * y + s.d02 * z + s.tx, s.d10 * x + s.d11 * y + s.d12 * z + s.ty,
          s.d20 * x + s.d21 * y + s.d22 * z + s.tz};
}

// Whether the segment from the camera to a point meets a unit sphere: the line does, on the camera's near side, and the
// point lies beyond the nearest point or in the sphere. e and w: from the sphere's centre to the camera and the point.
inline bool MeetsUnitSphere(float ex, float ey, float ez, float wx, float wy, float wz) {
  const float dx = wx - ex;
  const float dy = wy - ey;
  const float dz = wz - ez;
  const float a = dx * dx + dy * dy + dz * dz;
  const float c = ex * dx + ey * dy + ez * dz;
  const float nx = ey * wz - ez * wy;
  const float ny = ez * wx - ex * wz;
  const float nz = ex * wy - ey * wx;
  const bool meets = nx * nx + ny * ny + nz * nz <= a;
  const bool within = wx * wx + wy * wy + wz * wz <= 1.0F;
  return (c < 0.0F) & meets & ((a >= -c) | within);
}

// Thin plates are far away in their space: distances are taken from cross products there, as differences of squares would
// be off by more than the plate's rim allows.
VANTAGE_CLONED void MarkBehindEllipsoid(const UnitSpace& space, const PointArrays& given,
                                        std::uint32_t bit, std::uint32_t* marks) {
  const UnitSpace s = space;
  const PointArrays points = given;
  const int count = static_cast<int>(points.count);
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    const auto [wx, wy, wz] = ToUnit(s, points.x[i], points.y[i], points.z[i]);
    marks[i] |= MeetsUnitSphere(s.ex, s.ey, s.ez, wx, wy, wz) ? bit : 0U;
  }
}

// Behind the ellipsoid at one of the ends, or behind or in what is between them.
VANTAGE_CLONED void MarkBehindBar(const UnitSpace& space, const Vector3f& segment,
                                  const PointArrays& given, std::uint32_t bit,
                                  std::uint32_t* marks) {
  const UnitSpace s = space;
  const PointArrays points = given;
  const Vector3f camera(s.ex, s.ey, s.ez);
  const float e = segment.squaredNorm();
  const float f = segment.dot(camera);
  const Vector3f normal = segment.cross(camera);
  const Vector3f from_other = camera - segment;
  const float sx = segment.x(), sy = segment.y(), sz = segment.z();
  const float nx = normal.x(), ny = normal.y(), nz = normal.z();
  const float ox = from_other.x(), oy = from_other.y(), oz = from_other.z();
  const int count = static_cast<int>(points.count);
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    const auto [wx, wy, wz] = ToUnit(s, points.x[i], points.y[i], points.z[i]);
    const bool ends = MeetsUnitSphere(s.ex, s.ey, s.ez, wx, wy, wz) |
                      MeetsUnitSphere(ox, oy, oz, wx - sx, wy - sy, wz - sz);
    // Of the lines along the way and the segment: their distance, and whether the nearest points are on both. All is
    // multiplied by |way x segment|^2, which is too inexact where they are nearly parallel.
    const float dx = wx - s.ex;
    const float dy = wy - s.ey;
    const float dz = wz - s.ez;
    const float a = dx * dx + dy * dy + dz * dz;
    const float b = sx * dx + sy * dy + sz * dz;
    const float c = s.ex * dx + s.ey * dy + s.ez * dz;
    const float across = a * e - b * b;
    const float apart = nx * wx + ny * wy + nz * wz;
    const float on_segment = a * f - b * c;
    const float on_way = b * f - c * e;
    const bool passes = (across > 1e-4F * a * e) & (apart * apart <= across) &
                        (on_segment >= 0.0F) & (on_segment <= across) & (on_way >= 0.0F) &
                        (on_way <= across);
    // The point itself lies in the bar between its ends.
    const float at = sx * wx + sy * wy + sz * wz;
    const float ww = wx * wx + wy * wy + wz * wz;
    const bool within = (at >= 0.0F) & (at <= e) & (ww * e - at * at <= e);
    marks[i] |= (ends | passes | within) ? bit : 0U;
  }
}

}  // namespace

void MarkHidden(const SweptEllipsoid& solid_C, const Eigen::Isometry3d& X_CB,
                const PointArrays& points_B, std::uint32_t bit, std::uint32_t* marks) {
  const Vector3f segment = (solid_C.to_unit * (2.0 * solid_C.half)).cast<float>();
  const Vector3d end_C = solid_C.centre - solid_C.half;
  const Vector3f camera = (-solid_C.to_unit * end_C).cast<float>();
  const float e = segment.squaredNorm();
  const float nearest = e > 0.0F ? std::clamp(segment.dot(camera) / e, 0.0F, 1.0F) : 0.0F;
  if ((camera - nearest * segment).squaredNorm() <= 1.0F) return;
  const Matrix3f D = (solid_C.to_unit * X_CB.linear()).cast<float>();
  const Vector3f t = (solid_C.to_unit * (X_CB.translation() - end_C)).cast<float>();
  const UnitSpace space{D(0, 0), D(0, 1), D(0, 2),    D(1, 0),    D(1, 1),
                        D(1, 2), D(2, 0), D(2, 1),    D(2, 2),    t.x(),
                        t.y(),   t.z(),   camera.x(), camera.y(), camera.z()};
  if (e > 0.0F) {
    MarkBehindBar(space, segment, points_B, bit, marks);
  } else {
    MarkBehindEllipsoid(space, points_B, bit, marks);
  }
}

}  // namespace vantage::sim
