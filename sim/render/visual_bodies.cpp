#include "sim/render/visual_bodies.h"

#include <array>
#include <map>

#include "vantage/robot/mesh_file.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kGloss = 0.3F;

// A part of a visual in the shape's own frame.
struct ColouredMesh {
  TriangleMesh mesh;
  std::optional<Vector3f> colour;
};

// The part times a scale, which may mirror it.
TriangleMesh Scaled(const MeshPart& part, const Vector3d& scale) {
  TriangleMesh mesh;
  const Vector3f s = scale.cast<float>();
  for (const Vector3f& vertex : part.vertices) mesh.vertices.emplace_back(vertex.cwiseProduct(s));
  for (const Vector3f& normal : part.normals) {
    mesh.normals.emplace_back(normal.cwiseQuotient(s).normalized());
  }
  mesh.indices = part.indices;
  if (s.prod() < 0.0F) {
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
    }
  }
  return mesh;
}

std::vector<ColouredMesh> MakeMeshes(const Shape& shape, int segments) {
  struct Visitor {
    int segments;
    std::vector<ColouredMesh> operator()(const BoxShape& box) const {
      return {{BoxMesh(box.size), std::nullopt}};
    }
    std::vector<ColouredMesh> operator()(const CylinderShape& c) const {
      const Vector3d end(0.0, 0.0, 0.5 * c.length);
      const double bevel = 0.08 * std::min(c.radius, 0.5 * c.length);
      return {{CylinderMesh(-end, end, c.radius, bevel, segments), std::nullopt}};
    }
    std::vector<ColouredMesh> operator()(const SphereShape& sphere) const {
      return {
          {CapsuleMesh(Vector3d::Zero(), Vector3d::Zero(), sphere.radius, segments), std::nullopt}};
    }
    std::vector<ColouredMesh> operator()(const CapsuleShape& c) const {
      return {{CapsuleMesh(c.p_A, c.p_B, c.radius, segments), std::nullopt}};
    }
    std::vector<ColouredMesh> operator()(const MeshShape& mesh) const {
      std::vector<ColouredMesh> meshes;
      for (const MeshPart& part : ReadMeshFile(mesh.path)) {
        meshes.push_back({Scaled(part, mesh.scale), part.colour});
      }
      return meshes;
    }
  };
  return std::visit(Visitor{segments}, shape);
}

// Gathers meshes by frame and colour: a body costs a draw call, whatever its size.
class BodyCollector {
 public:
  void Add(int frame, const Vector3f& colour, const TriangleMesh& mesh, const Isometry3d& X) {
    const auto [entry, is_new] =
        index_.try_emplace({frame, {colour.x(), colour.y(), colour.z()}}, bodies_.size());
    if (is_new) bodies_.push_back({frame, {}, colour, kGloss});
    Append(&bodies_[entry->second].mesh, mesh, X);
  }
  std::vector<Body> Take() { return std::move(bodies_); }

 private:
  std::map<std::pair<int, std::array<float, 3>>, std::size_t> index_;
  std::vector<Body> bodies_;
};

}  // namespace

std::vector<Body> MakeVisualBodies(const ArmModel& arm, const Vector3f& uncoloured, int segments,
                                   std::vector<std::string>* warnings) {
  BodyCollector bodies;
  for (const ArmVisual& visual : arm.visuals()) {
    const bool base = visual.link < 0;
    const int frame = base ? kWorldFrame : visual.link;
    const Isometry3d X_FL = base ? arm.X_WBase() : Isometry3d::Identity();
    try {
      for (const ColouredMesh& part : MakeMeshes(visual.shape, segments)) {
        const Vector3f colour = visual.colour ? *visual.colour : part.colour.value_or(uncoloured);
        bodies.Add(frame, colour, part.mesh, X_FL * visual.X_LV);
      }
    } catch (const MeshError& error) {
      if (warnings != nullptr) {
        warnings->push_back(std::string(error.what()) + "; the link's capsules are drawn instead");
      }
      for (const Capsule& capsule : arm.capsules()) {
        if (capsule.link != visual.link) continue;
        bodies.Add(frame, uncoloured,
                   CapsuleMesh(capsule.p_LA, capsule.p_LB, capsule.radius, segments), X_FL);
      }
    }
  }
  return bodies.Take();
}

}  // namespace vantage::sim
