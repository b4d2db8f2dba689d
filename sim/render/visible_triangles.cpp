#include "sim/render/visible_triangles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "sim/render/detail.h"
#include "sim/render/hidden_points.h"
#include "sim/render/vector_clones.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// Rasterisers round to a grid of 1/256 px: a triangle may grow by as much [px].
constexpr float kSnap = 1.0F / 64.0F;

// Most occluders in use at a time: the next one costs more than the triangles that it hides.
constexpr std::size_t kMaxOccluders = 12;

// A step of the depth buffer next to 1, in units of Z² over the near distance; doubled as depths are interpolated in single
// precision.
constexpr double kDepthStep = 2.0 / (1 << 24);

// Radius of the sphere about the centre that holds it [m].
double Reach(const SweptEllipsoid& solid) {
  return solid.half.norm() + solid.semi_axes.maxCoeff();
}

// How much of it is within the bounds of one pass or another.
double AreaWithin(const std::vector<RayBounds>& bounds, const RayBounds& seen) {
  double area = 0.0;
  for (const RayBounds& b : bounds) area += Area(Intersection(b, seen));
  return area;
}

float Luminance(const Vector3f& colour) {
  return colour.dot(Vector3f(0.2126F, 0.7152F, 0.0722F));
}

}  // namespace

float Brightness(const Light& light, const Vector3f& colour, const Vector3d& normal_W) noexcept {
  const Vector3d light_W = light.direction_W.cast<double>().normalized();
  const double sky = light.ambient * (0.8 + 0.2 * normal_W.z());
  const double direct = (1.0 - light.ambient) * std::max(0.0, normal_W.dot(light_W));
  return Luminance(colour) * static_cast<float>(sky + direct);
}

VisibleTriangles::VisibleTriangles(const Scene& scene, const CameraModel& camera, double near)
    : camera_(camera),
      light_(scene.light),
      shortcuts_(scene.shortcuts),
      near_(near),
      bent_(!camera.distortion.none()) {
  for (const Body& body : scene.bodies) Add(body.frame, body.mesh, body.colour, nullptr);
  for (const SceneMarker& marker : scene.markers) {
    if (!marker.plate) continue;
    const TriangleMesh plate = PlainMarkerPlate(marker.marker);
    TriangleMesh drawn = plate;
    drawn.indices.resize(plate.indices.size() - std::size_t{3} * kPlainPlateSides);
    Add(marker.frame, drawn, *marker.plate, &plate);
  }
  ray_x_.resize(x_.size());
  ray_y_.resize(x_.size());
  facing_.resize(plane_d_.size());
  hidden_.resize(x_.size());
}

void VisibleTriangles::Add(int frame, const TriangleMesh& mesh, const Vector3f& colour,
                           const TriangleMesh* solid) {
  Mesh added;
  added.frame = frame;
  added.brightness = Luminance(colour);
  added.bound = Bound(mesh);
  const std::vector<CoarseMesh> levels =
      shortcuts_.detail > 0.0 ? MakeLevelsOfDetail(mesh) : std::vector<CoarseMesh>{{mesh, 0.0}};
  for (const CoarseMesh& coarse : levels) {
    Level level = Store(coarse.mesh);
    if (shortcuts_.hidden) {
      level.occluders = FindOccluders(solid == nullptr ? coarse.mesh : *solid);
      level.slack = solid == nullptr ? 0.0 : coarse.error;
    }
    added.levels.push_back(std::move(level));
    added.errors.push_back(coarse.error);
  }
  meshes_.push_back(std::move(added));
}

VisibleTriangles::Level VisibleTriangles::Store(const TriangleMesh& mesh) {
  Level stored;
  stored.first_vertex = static_cast<std::uint32_t>(x_.size());
  stored.first_triangle = static_cast<std::uint32_t>(plane_d_.size());
  stored.vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  stored.triangles = static_cast<std::uint32_t>(mesh.triangles());
  for (const Vector3f& p : mesh.vertices) {
    x_.push_back(p.x());
    y_.push_back(p.y());
    z_.push_back(p.z());
  }
  for (const Vector3f& n : mesh.normals) {
    nx_.push_back(n.x());
    ny_.push_back(n.y());
    nz_.push_back(n.z());
  }
  for (std::uint32_t t = 0; t < stored.triangles; ++t) {
    const auto corner = [&](int k) -> Vector3d {
      return mesh.vertices[mesh.indices[3 * t + k]].cast<double>();
    };
    for (int k = 0; k < 3; ++k) corners_.push_back(stored.first_vertex + mesh.indices[3 * t + k]);
    const Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    plane_x_.push_back(static_cast<float>(n.x()));
    plane_y_.push_back(static_cast<float>(n.y()));
    plane_z_.push_back(static_cast<float>(n.z()));
    plane_d_.push_back(static_cast<float>(n.dot(corner(0))));
  }
  return stored;
}

// By distance alone, so that every window of an image shows the same.
void VisibleTriangles::ChooseDetail(Mesh* mesh) const {
  const double nearest = mesh->centre_C.norm() - mesh->bound.radius;
  const double tolerance = shortcuts_.detail * nearest / std::max(camera_.fx, camera_.fy);
  const int level = mesh->crosses_near ? 0 : ChooseLevelOfDetail(mesh->errors, tolerance);
  mesh->shown = &mesh->levels[level];
}

void VisibleTriangles::Place(const Isometry3d& X_CW, const SceneState& state,
                             const std::vector<RayBounds>& bounds, LitVertex* vertices) {
  const Vector3d light_W = light_.direction_W.cast<double>().normalized();
  for (Mesh& mesh : meshes_) {
    const Isometry3d X_WB = FramePose(state, mesh.frame);
    mesh.X_CB = X_CW * X_WB;
    mesh.centre_C = mesh.X_CB * mesh.bound.centre;
    mesh.placed = std::any_of(bounds.begin(), bounds.end(), [&](const RayBounds& b) {
      return SphereMeets(b, mesh.centre_C, mesh.bound.radius);
    });
    if (!mesh.placed) continue;
    mesh.crosses_near = mesh.centre_C.z() - mesh.bound.radius < 1.01 * near_;
    ChooseDetail(&mesh);
    PlaceVertices(&mesh, X_WB.linear().transpose() * light_W, X_WB.linear().row(2).transpose(),
                  vertices);
    FindFacing(mesh, mesh.X_CB.inverse().translation());
  }
  HideBehindParts(bounds);
}

// As small as a rasteriser's rounding, of pixels and of depths, needs them.
void VisibleTriangles::FindOccludersInUse(const std::vector<RayBounds>& bounds) {
  occluders_.clear();
  if (bent_) return;  // Images of edges are not straight there, and those of a mesh's edges are.
  for (const Mesh& mesh : meshes_) {
    if (!mesh.placed || mesh.crosses_near) continue;
    const Occluders& occluders = mesh.shown->occluders;
    for (const SweptEllipsoid& solid : occluders.solids) {
      const double far = (mesh.X_CB * solid.centre).norm() + Reach(solid);
      const double pixel = far / std::min(camera_.fx, camera_.fy);
      const double depth_step = far * far / near_ * kDepthStep;
      const auto kept = Shrink(solid, std::max(kSnap * pixel, depth_step) + mesh.shown->slack);
      if (!kept) continue;
      const SweptEllipsoid solid_C = Move(mesh.X_CB, *kept);
      const std::optional<RayBounds> seen = BoundRays(solid_C);
      if (!seen) continue;
      const double size = AreaWithin(bounds, *seen);
      if (size <= 0.0) continue;
      occluders_.push_back({size, solid_C, *seen, occluders.one_part ? &mesh : nullptr});
    }
  }
  const std::size_t used = std::min(kMaxOccluders, occluders_.size());
  std::partial_sort(occluders_.begin(), occluders_.begin() + static_cast<std::ptrdiff_t>(used),
                    occluders_.end(),
                    [](const SeenOccluder& a, const SeenOccluder& b) { return a.size > b.size; });
  occluders_.resize(used);
}

void VisibleTriangles::HideBehindParts(const std::vector<RayBounds>& bounds) {
  FindOccludersInUse(bounds);
  for (const Mesh& mesh : meshes_) {
    if (!mesh.placed) continue;
    std::fill_n(hidden_.begin() + mesh.shown->first_vertex, mesh.shown->vertices, 0U);
    if (mesh.crosses_near) continue;
    const double farthest = mesh.centre_C.norm() + mesh.bound.radius;
    for (std::size_t k = 0; k < occluders_.size(); ++k) {
      const SeenOccluder& occluder = occluders_[k];
      const SweptEllipsoid& solid_C = occluder.solid_C;
      if (occluder.own == &mesh) continue;
      if (farthest < solid_C.centre.norm() - Reach(solid_C)) continue;
      if (AreaWithin(bounds, Intersection(mesh.seen, occluder.seen)) <= 0.0) continue;
      const std::uint32_t first = mesh.shown->first_vertex;
      MarkHidden(solid_C, mesh.X_CB, {&x_[first], &y_[first], &z_[first], mesh.shown->vertices},
                 1U << k, &hidden_[first]);
    }
  }
}

// Lit as by Brightness().
VANTAGE_CLONED void VisibleTriangles::PlaceVertices(Mesh* placed, const Vector3d& light_B,
                                                    const Vector3d& up_B, LitVertex* vertices) {
  const Mesh& mesh = *placed;
  const Eigen::Matrix<float, 3, 4> X = mesh.X_CB.matrix().topRows<3>().cast<float>();
  const float r00 = X(0, 0), r01 = X(0, 1), r02 = X(0, 2), tx = X(0, 3);
  const float r10 = X(1, 0), r11 = X(1, 1), r12 = X(1, 2), ty = X(1, 3);
  const float r20 = X(2, 0), r21 = X(2, 1), r22 = X(2, 2), tz = X(2, 3);
  const float ambient = mesh.brightness * light_.ambient;
  const Vector3f direct = mesh.brightness * (1.0F - light_.ambient) * light_B.cast<float>();
  const Vector3f sky = 0.2F * ambient * up_B.cast<float>();
  const float base = 0.8F * ambient;
  const float dx = direct.x(), dy = direct.y(), dz = direct.z();
  const float sx = sky.x(), sy = sky.y(), sz = sky.z();
  const std::uint32_t first = mesh.shown->first_vertex;
  const float* const x = x_.data() + first;
  const float* const y = y_.data() + first;
  const float* const z = z_.data() + first;
  const float* const nx = nx_.data() + first;
  const float* const ny = ny_.data() + first;
  const float* const nz = nz_.data() + first;
  LitVertex* const vertex = vertices + first;
  float* const ray_x = ray_x_.data() + first;
  float* const ray_y = ray_y_.data() + first;
  const int count = static_cast<int>(mesh.shown->vertices);
  float x0 = 1e9F, x1 = -1e9F, y0 = 1e9F, y1 = -1e9F;
#pragma omp simd reduction(min : x0, y0) reduction(max : x1, y1)
  for (int i = 0; i < count; ++i) {
    const float px = r00 * x[i] + r01 * y[i] + r02 * z[i] + tx;
    const float py = r10 * x[i] + r11 * y[i] + r12 * z[i] + ty;
    const float pz = r20 * x[i] + r21 * y[i] + r22 * z[i] + tz;
    const float lit = dx * nx[i] + dy * ny[i] + dz * nz[i];
    const float above = sx * nx[i] + sy * ny[i] + sz * nz[i];
    vertex[i].position[0] = px;
    vertex[i].position[1] = py;
    vertex[i].position[2] = pz;
    vertex[i].brightness = base + above + (lit > 0.0F ? lit : 0.0F);
    const float inverse = 1.0F / pz;
    const float u = px * inverse;
    const float v = py * inverse;
    ray_x[i] = u;
    ray_y[i] = v;
    x0 = u < x0 ? u : x0;
    x1 = u > x1 ? u : x1;
    y0 = v < y0 ? v : y0;
    y1 = v > y1 ? v : y1;
  }
  placed->seen = {x0, x1, y0, y1};
}

VANTAGE_CLONED void VisibleTriangles::FindFacing(const Mesh& mesh, const Vector3d& eye_B) {
  const Vector3f eye = eye_B.cast<float>();
  const float ex = eye.x(), ey = eye.y(), ez = eye.z();
  const std::uint32_t first = mesh.shown->first_triangle;
  const float* const nx = plane_x_.data() + first;
  const float* const ny = plane_y_.data() + first;
  const float* const nz = plane_z_.data() + first;
  const float* const d = plane_d_.data() + first;
  std::uint8_t* const facing = facing_.data() + first;
  const int count = static_cast<int>(mesh.shown->triangles);
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    facing[i] = nx[i] * ex + ny[i] * ey + nz[i] * ez > d[i] ? 1 : 0;
  }
}

std::size_t VisibleTriangles::Select(const RayBounds& bounds,
                                     std::vector<std::uint32_t>* indices) const {
  if (indices->size() < corners_.size()) indices->resize(corners_.size());
  std::uint32_t* next = indices->data();
  const auto x0 = static_cast<float>(bounds.x0);
  const auto x1 = static_cast<float>(bounds.x1);
  const auto y0 = static_cast<float>(bounds.y0);
  const auto y1 = static_cast<float>(bounds.y1);
  const auto fx = static_cast<float>(camera_.fx);
  const auto fy = static_cast<float>(camera_.fy);
  const auto u0 = static_cast<float>(camera_.u0);
  const auto v0 = static_cast<float>(camera_.v0);
  // Pixel centres are counted in rows and columns: not where they are sheared or bent.
  const bool straight = !bent_ && camera_.skew == 0.0;
  for (const Mesh& mesh : meshes_) {
    if (!mesh.placed || !SphereMeets(bounds, mesh.centre_C, mesh.bound.radius)) continue;
    for (std::uint32_t t = mesh.shown->first_triangle;
         t < mesh.shown->first_triangle + mesh.shown->triangles; ++t) {
      if (facing_[t] == 0) continue;
      const std::uint32_t* const corner = corners_.data() + std::size_t{3} * t;
      if ((hidden_[corner[0]] & hidden_[corner[1]] & hidden_[corner[2]]) != 0) continue;
      if (!mesh.crosses_near) {
        const float ax = ray_x_[corner[0]], bx = ray_x_[corner[1]], cx = ray_x_[corner[2]];
        const float ay = ray_y_[corner[0]], by = ray_y_[corner[1]], cy = ray_y_[corner[2]];
        const float left = std::min(ax, std::min(bx, cx));
        const float right = std::max(ax, std::max(bx, cx));
        const float top = std::min(ay, std::min(by, cy));
        const float bottom = std::max(ay, std::max(by, cy));
        // A lens bends the rays to the corners; the edges between them stay straight. They part by less
        // than the square of their length for any lens whose image is one.
        const float slack =
            bent_ ? std::max(right - left, bottom - top) * std::max(right - left, bottom - top)
                  : 0.0F;
        if (left - slack > x1 || right + slack < x0 || top - slack > y1 || bottom + slack < y0) {
          continue;
        }
        if (straight) {
          const float first_u = std::ceil(fx * left + u0 - kSnap);
          const float first_v = std::ceil(fy * top + v0 - kSnap);
          if (first_u > fx * right + u0 + kSnap || first_v > fy * bottom + v0 + kSnap) continue;
        }
      }
      next = std::copy_n(corner, 3, next);
    }
  }
  return static_cast<std::size_t>(next - indices->data());
}

}  // namespace vantage::sim
