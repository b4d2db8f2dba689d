#include "sim/render/visible_triangles.h"

#include <algorithm>
#include <cmath>

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// Rasterisers round to a grid of 1/256 px: a triangle may grow by as much [px].
constexpr float kSnap = 1.0F / 64.0F;

float Luminance(const Vector3f& colour) {
  return colour.dot(Vector3f(0.2126F, 0.7152F, 0.0722F));
}

}  // namespace

VisibleTriangles::VisibleTriangles(const std::vector<Body>& bodies, const Light& light,
                                   const CameraModel& camera, double near)
    : camera_(camera), light_(light), near_(near), bent_(!camera.distortion.none()) {
  for (const Body& body : bodies) {
    Mesh mesh;
    mesh.frame = body.frame;
    mesh.brightness = Luminance(body.colour);
    mesh.bound = Bound(body.mesh);
    mesh.first_vertex = static_cast<std::uint32_t>(x_.size());
    mesh.first_triangle = static_cast<std::uint32_t>(plane_d_.size());
    mesh.vertices = static_cast<std::uint32_t>(body.mesh.vertices.size());
    mesh.triangles = static_cast<std::uint32_t>(body.mesh.triangles());
    for (const Vector3f& p : body.mesh.vertices) {
      x_.push_back(p.x());
      y_.push_back(p.y());
      z_.push_back(p.z());
    }
    for (const Vector3f& n : body.mesh.normals) {
      nx_.push_back(n.x());
      ny_.push_back(n.y());
      nz_.push_back(n.z());
    }
    for (std::uint32_t t = 0; t < mesh.triangles; ++t) {
      const auto corner = [&](int k) -> Vector3d {
        return body.mesh.vertices[body.mesh.indices[3 * t + k]].cast<double>();
      };
      for (int k = 0; k < 3; ++k) {
        corners_.push_back(mesh.first_vertex + body.mesh.indices[3 * t + k]);
      }
      const Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      plane_x_.push_back(static_cast<float>(n.x()));
      plane_y_.push_back(static_cast<float>(n.y()));
      plane_z_.push_back(static_cast<float>(n.z()));
      plane_d_.push_back(static_cast<float>(n.dot(corner(0))));
    }
    meshes_.push_back(mesh);
  }
  ray_x_.resize(x_.size());
  ray_y_.resize(x_.size());
  facing_.resize(plane_d_.size());
}

void VisibleTriangles::Place(const Isometry3d& X_CW, const SceneState& state,
                             const std::vector<RayBounds>& bounds, LitVertex* vertices) {
  const Vector3d light_W = light_.direction_W.cast<double>().normalized();
  for (Mesh& mesh : meshes_) {
    const Isometry3d X_WB = FramePose(state, mesh.frame);
    const Isometry3d X_CB = X_CW * X_WB;
    mesh.centre_C = X_CB * mesh.bound.centre;
    mesh.placed = std::any_of(bounds.begin(), bounds.end(), [&](const RayBounds& b) {
      return SphereMeets(b, mesh.centre_C, mesh.bound.radius);
    });
    if (!mesh.placed) continue;
    mesh.crosses_near = mesh.centre_C.z() - mesh.bound.radius < 1.01 * near_;
    PlaceVertices(mesh, X_CB, X_WB.linear().transpose() * light_W, X_WB.linear().row(2).transpose(),
                  vertices);
    FindFacing(mesh, X_CB.inverse().translation());
  }
}

// Lambert's law for the one light, a little more from the sky than from the floor, and the ambient light.
void VisibleTriangles::PlaceVertices(const Mesh& mesh, const Isometry3d& X_CB,
                                     const Vector3d& light_B, const Vector3d& up_B,
                                     LitVertex* vertices) {
  const Eigen::Matrix<float, 3, 4> X = X_CB.matrix().topRows<3>().cast<float>();
  const float r00 = X(0, 0), r01 = X(0, 1), r02 = X(0, 2), tx = X(0, 3);
  const float r10 = X(1, 0), r11 = X(1, 1), r12 = X(1, 2), ty = X(1, 3);
  const float r20 = X(2, 0), r21 = X(2, 1), r22 = X(2, 2), tz = X(2, 3);
  const float ambient = mesh.brightness * light_.ambient;
  const Vector3f direct = mesh.brightness * (1.0F - light_.ambient) * light_B.cast<float>();
  const Vector3f sky = 0.2F * ambient * up_B.cast<float>();
  const float base = 0.8F * ambient;
  const float dx = direct.x(), dy = direct.y(), dz = direct.z();
  const float sx = sky.x(), sy = sky.y(), sz = sky.z();
  const std::uint32_t first = mesh.first_vertex;
  const float* const x = x_.data() + first;
  const float* const y = y_.data() + first;
  const float* const z = z_.data() + first;
  const float* const nx = nx_.data() + first;
  const float* const ny = ny_.data() + first;
  const float* const nz = nz_.data() + first;
  LitVertex* const vertex = vertices + first;
  float* const ray_x = ray_x_.data() + first;
  float* const ray_y = ray_y_.data() + first;
  const int count = static_cast<int>(mesh.vertices);
#pragma omp simd
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
    ray_x[i] = px * inverse;
    ray_y[i] = py * inverse;
  }
}

void VisibleTriangles::FindFacing(const Mesh& mesh, const Vector3d& eye_B) {
  const Vector3f eye = eye_B.cast<float>();
  const float ex = eye.x(), ey = eye.y(), ez = eye.z();
  const std::uint32_t first = mesh.first_triangle;
  const float* const nx = plane_x_.data() + first;
  const float* const ny = plane_y_.data() + first;
  const float* const nz = plane_z_.data() + first;
  const float* const d = plane_d_.data() + first;
  std::uint8_t* const facing = facing_.data() + first;
  const int count = static_cast<int>(mesh.triangles);
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    facing[i] = nx[i] * ex + ny[i] * ey + nz[i] * ez > d[i] ? 1 : 0;
  }
}

void VisibleTriangles::Select(const RayBounds& bounds, std::vector<std::uint32_t>* indices) const {
  indices->resize(corners_.size());
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
    for (std::uint32_t t = mesh.first_triangle; t < mesh.first_triangle + mesh.triangles; ++t) {
      if (facing_[t] == 0) continue;
      const std::uint32_t* const corner = corners_.data() + std::size_t{3} * t;
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
  indices->resize(static_cast<std::size_t>(next - indices->data()));
}

}  // namespace vantage::sim
