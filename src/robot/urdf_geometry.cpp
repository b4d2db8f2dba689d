#include "urdf_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "message_text.h"
#include "package_path.h"
#include "vantage/robot/capsule_fit.h"
#include "vantage/robot/mesh_file.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Of one geometry: an L needs two, a U three.
constexpr int kMaxCapsulesPerShape = 3;

TriangleSurface BoxSurface(const Vector3d& size) {
  TriangleSurface surface;
  for (int i = 0; i < 8; ++i) {
    surface.points.push_back(
        0.5 * size.cwiseProduct(
                  Vector3d((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)));
  }
  const std::array<std::array<std::uint32_t, 4>, 6> faces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& face : faces) {
    surface.triangles.push_back({face[0], face[1], face[2]});
    surface.triangles.push_back({face[0], face[2], face[3]});
  }
  return surface;
}

TriangleSurface MeshSurface(const MeshShape& mesh) {
  TriangleSurface surface;
  for (const MeshPart& part : ReadMeshFile(mesh.path)) {
    const auto first = static_cast<std::uint32_t>(surface.points.size());
    for (const Eigen::Vector3f& vertex : part.vertices) {
      surface.points.emplace_back(vertex.cast<double>().cwiseProduct(mesh.scale));
    }
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      surface.triangles.push_back(
          {first + part.indices[i], first + part.indices[i + 1], first + part.indices[i + 2]});
    }
  }
  return surface;
}

// Throws MeshError.
std::vector<CapsuleShape> CapsulesRound(const Shape& shape) {
  struct Visitor {
    std::vector<CapsuleShape> operator()(const BoxShape& box) const {
      return FitCapsules(BoxSurface(box.size), kMaxCapsulesPerShape);
    }
    std::vector<CapsuleShape> operator()(const CylinderShape& cylinder) const {
      return {FitCapsuleToCylinder(cylinder.radius, cylinder.length)};
    }
    std::vector<CapsuleShape> operator()(const SphereShape& sphere) const {
      return {{Vector3d::Zero(), Vector3d::Zero(), sphere.radius}};
    }
    std::vector<CapsuleShape> operator()(const CapsuleShape& capsule) const { return {capsule}; }
    std::vector<CapsuleShape> operator()(const MeshShape& mesh) const {
      return FitCapsules(MeshSurface(mesh), kMaxCapsulesPerShape);
    }
  };
  return std::visit(Visitor{}, shape);
}

CapsuleShape Moved(const CapsuleShape& capsule, const Isometry3d& X) {
  return {X * capsule.p_A, X * capsule.p_B, capsule.radius};
}

bool IsPositive(double value) {
  return std::isfinite(value) && value > 0.0;
}

class BodyMaker {
 public:
  BodyMaker(const UrdfDocument& document, const std::vector<std::string>& package_folders,
            double stand_in_radius, std::vector<std::string>* warnings)
      : document_(document),
        package_folders_(package_folders),
        stand_in_radius_(stand_in_radius),
        warnings_(warnings) {}

  void AddLink(const urdf::Link& link, const Attachment& attachment) {
    const Geometry seen = ReadVisuals(link);
    const std::vector<CapsuleShape> capsules = FitLink(link, seen);
    const auto place = [&](Placed part) {
      bodies_.visuals.push_back(
          {attachment.link, attachment.X_LU * part.X_US, part.shape, part.colour});
    };
    for (const Placed& part : seen.parts) place(part);
    for (const CapsuleShape& capsule : capsules) {
      bodies_.capsules.push_back({attachment.link, attachment.X_LU * capsule.p_A,
                                  attachment.X_LU * capsule.p_B, capsule.radius});
      if (!seen.complete) place({capsule, Isometry3d::Identity(), {}});
    }
  }

  UrdfBodies Take() {
    WarnOfPackages();
    DropContained();
    return std::move(bodies_);
  }

 private:
  // A shape in the URDF link's frame.
  struct Placed {
    Shape shape;
    Isometry3d X_US;
    std::optional<Eigen::Vector3f> colour;
  };

  // Shapes of one kind of a link.
  struct Geometry {
    std::vector<Placed> parts;
    bool any{false};      // The file names some.
    bool complete{true};  // All of them are there.
  };

  Geometry ReadVisuals(const urdf::Link& link) {
    Geometry geometry;
    for (const auto& visual : link.visual_array) {
      if (visual == nullptr || visual->geometry == nullptr) continue;
      const urdf::MaterialSharedPtr& material = visual->material;
      if (material != nullptr && material->color.a == 0.0F) continue;  // Not to be seen.
      std::optional<Eigen::Vector3f> colour;
      if (material != nullptr && material->texture_filename.empty()) {
        const urdf::Color& c = material->color;
        colour = Eigen::Vector3f(c.r, c.g, c.b).cwiseMax(0.0F).cwiseMin(1.0F);
      }
      Read(link, *visual->geometry, visual->origin, "visual", colour, &geometry);
    }
    return geometry;
  }

  Geometry ReadCollisions(const urdf::Link& link) {
    Geometry geometry;
    for (const auto& collision : link.collision_array) {
      if (collision == nullptr || collision->geometry == nullptr) continue;
      Read(link, *collision->geometry, collision->origin, "collision", {}, &geometry);
    }
    return geometry;
  }

  void Read(const urdf::Link& link, const urdf::Geometry& source, const urdf::Pose& origin,
            const char* kind, const std::optional<Eigen::Vector3f>& colour, Geometry* geometry) {
    const Isometry3d X_US = ToEigen(origin);
    if (!X_US.matrix().allFinite()) {
      document_.FailLink(link.name, std::string(kind) + ": has an origin that is not finite");
    }
    geometry->any = true;
    if (const std::optional<Shape> shape = ReadShape(link, source, kind)) {
      geometry->parts.push_back({*shape, X_US, colour});
    } else {
      geometry->complete = false;
    }
  }

  // Capsules in the URDF link's frame: round the collision geometry; round the visual one when there
  // is no other, or a part of it is missing; from joint to joint when that will not do either.
  std::vector<CapsuleShape> FitLink(const urdf::Link& link, const Geometry& seen) {
    std::vector<CapsuleShape> capsules;
    const auto fit = [&](const Geometry& geometry, const char* kind) {
      bool complete = geometry.any && geometry.complete;
      for (const Placed& part : geometry.parts) {
        try {
          for (const CapsuleShape& capsule : CapsulesRound(part.shape)) {
            capsules.push_back(Moved(capsule, part.X_US));
          }
        } catch (const MeshError& error) {
          Warn(link, kind, error.what());
          complete = false;
        }
      }
      return complete;
    };
    const Geometry solid = ReadCollisions(link);
    if (fit(solid, "collision") || fit(seen, "visual")) return capsules;
    if (solid.any || seen.any) capsules.push_back(JointToJoint(link));
    return capsules;
  }

  // From the link's own joint to the farthest one below it; a ball where they coincide.
  CapsuleShape JointToJoint(const urdf::Link& link) const {
    CapsuleShape capsule{Vector3d::Zero(), Vector3d::Zero(), stand_in_radius_};
    for (const auto& joint : link.child_joints) {
      const Vector3d p = ToEigen(joint->parent_to_joint_origin_transform.position);
      if (p.norm() > capsule.p_B.norm()) capsule.p_B = p;
    }
    return capsule;
  }

  // nullopt, and a warning, when it is a mesh that is not there.
  std::optional<Shape> ReadShape(const urdf::Link& link, const urdf::Geometry& geometry,
                                 const char* kind) {
    const auto require = [&](bool condition, const std::string& reason) {
      if (!condition) document_.FailLink(link.name, std::string(kind) + ": " + reason);
    };
    switch (geometry.type) {
      case urdf::Geometry::BOX: {
        const Vector3d size = ToEigen(static_cast<const urdf::Box&>(geometry).dim);
        require(IsPositive(size.minCoeff()) && size.allFinite(),
                "a box needs three sizes > 0, has " + Text({size.x(), size.y(), size.z()}));
        return BoxShape{size};
      }
      case urdf::Geometry::CYLINDER: {
        const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
        require(IsPositive(cylinder.radius) && IsPositive(cylinder.length),
                "a cylinder needs a radius and a length > 0, has " +
                    Text({cylinder.radius, cylinder.length}));
        return CylinderShape{cylinder.radius, cylinder.length};
      }
      case urdf::Geometry::SPHERE: {
        const double radius = static_cast<const urdf::Sphere&>(geometry).radius;
        require(IsPositive(radius), "a sphere needs a radius > 0, has " + Text({radius}));
        return SphereShape{radius};
      }
      case urdf::Geometry::MESH:
        break;
    }
    const auto& mesh = static_cast<const urdf::Mesh&>(geometry);
    const Vector3d scale = ToEigen(mesh.scale);
    require(scale.allFinite() && scale.cwiseAbs().minCoeff() > 0.0,
            "a mesh needs a scale other than 0, has " + Text({scale.x(), scale.y(), scale.z()}));
    const MeshLocation location = FindMesh(mesh.filename, document_.path(), package_folders_);
    if (location.path.empty()) {
      if (location.missing_package.empty()) {
        Warn(link, kind, location.reason_missing);
      } else if (warned_.insert(link.name + location.reason_missing).second) {
        missing_[location.missing_package].push_back({&link, kind, location.reason_missing});
      }
      return std::nullopt;
    }
    return MeshShape{location.path, scale};
  }

  // Once for each reason: visual and collision geometry often name the same file.
  void Warn(const urdf::Link& link, const char* kind, const std::string& reason) {
    if (!warned_.insert(link.name + reason).second) return;
    warnings_->push_back(document_.Link(link.name) + ", " + kind + ": " + reason + kStandIn);
  }

  // A package that is not there is one thing to mend, however many meshes it holds.
  void WarnOfPackages() {
    for (const auto& [package, meshes] : missing_) {
      const Missing& first = meshes.front();
      std::string text = document_.Link(first.link->name) + ", " + first.kind + ": " + first.reason;
      if (meshes.size() > 1) {
        text += ", nor " + std::to_string(meshes.size() - 1) + " more of package '" + package + "'";
      }
      warnings_->push_back(text + kStandIn);
    }
  }

  void DropContained() {
    std::vector<Capsule>& all = bodies_.capsules;
    std::vector<Capsule> kept;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool inside = [&] {
        for (std::size_t j = 0; j < all.size(); ++j) {
          if (i == j || all[i].link != all[j].link) continue;
          const CapsuleShape outer{all[j].p_LA, all[j].p_LB, all[j].radius};
          const CapsuleShape inner{all[i].p_LA, all[i].p_LB, all[i].radius};
          // Of two that are equal the first stays.
          if (Contains(outer, inner) && !(j > i && Contains(inner, outer))) return true;
        }
        return false;
      }();
      if (!inside) kept.push_back(all[i]);
    }
    all = std::move(kept);
  }

  struct Missing {
    const urdf::Link* link;
    const char* kind;
    std::string reason;
  };
  static constexpr const char* kStandIn = "; capsules stand in";

  const UrdfDocument& document_;
  const std::vector<std::string>& package_folders_;
  double stand_in_radius_;
  std::vector<std::string>* warnings_;
  std::set<std::string> warned_;
  std::map<std::string, std::vector<Missing>> missing_;  // By package.
  UrdfBodies bodies_;
};

}  // namespace

UrdfBodies MakeBodies(const UrdfDocument& document,
                      const std::map<std::string, Attachment>& attachments,
                      const std::vector<std::string>& package_folders, double stand_in_radius,
                      std::vector<std::string>* warnings) {
  BodyMaker maker(document, package_folders, stand_in_radius, warnings);
  // From the base on, so that bodies come in the order of the arm's links.
  std::vector<std::pair<int, std::string>> order;
  for (const auto& [name, attachment] : attachments) order.emplace_back(attachment.link, name);
  std::sort(order.begin(), order.end());
  for (const auto& [link, name] : order) {
    maker.AddLink(*document.model().getLink(name), attachments.at(name));
  }
  return maker.Take();
}

}  // namespace vantage
