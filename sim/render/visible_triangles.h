#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "sim/render/occluders.h"
#include "sim/render/ray_bounds.h"
#include "sim/render/scene.h"

/// @file
/// The bodies of a scene as one camera sees them: placed, lit, and without the triangles that no pixel can
/// show. Software rasterisers spend most of their time on those, and on the draw calls of many bodies; here
/// what is left is one stream of triangles.

namespace vantage::sim {

/// A vertex in the camera's frame, with the brightness of its surface.
struct LitVertex {
  float position[3];  ///< [m].
  float brightness;   ///< 0 to 1.
};

/// How bright a surface is without its gloss: Lambert's law for the one light, a little more from the sky than from
/// the floor, and the ambient light.
/// @param normal_W  Unit.
[[nodiscard]] float Brightness(const Light& light, const Eigen::Vector3f& colour,
                               const Eigen::Vector3d& normal_W) noexcept;

class VisibleTriangles {
 public:
  /// Of the markers' plates all but the faces, which are part of the markers' own images.
  /// @param camera  Its windows are what Select() is asked for. The distance within which a point is not
  ///   drawn is `near` [m].
  VisibleTriangles(const Scene& scene, const CameraModel& camera, double near);

  [[nodiscard]] int vertex_count() const noexcept { return static_cast<int>(x_.size()); }

  /// Places and lights the bodies that may be seen within one of the bounds.
  /// @param vertices  Takes the vertices of all bodies, vertex_count(); only written to, and only where
  ///   a body was placed.
  void Place(const Eigen::Isometry3d& X_CW, const SceneState& state,
             const std::vector<RayBounds>& bounds, LitVertex* vertices);

  /// Triangles of the placed bodies that face the camera and may cover a pixel centre within the bounds,
  /// in the bodies' order: three indices of vertices each. None that shows is left out; many of those that
  /// are hidden wholly behind one part of a body are.
  /// @param bounds   One of those given to Place().
  /// @param indices  Takes them; grows as needed and never shrinks.
  /// @returns how many indices there are.
  std::size_t Select(const RayBounds& bounds, std::vector<std::uint32_t>* indices) const;

 private:
  // A level of detail: where its vertices and triangles are in the arrays below, and what hides behind it.
  struct Level {
    std::uint32_t first_vertex{0}, first_triangle{0};
    std::uint32_t vertices{0}, triangles{0};
    Occluders occluders;
    double slack{0.0};  // The mesh may be as much smaller than that which the occluders are of [m].
  };

  // Of one body, in its own frame.
  struct Mesh {
    int frame{kWorldFrame};
    float brightness{0.0F};
    BoundingSphere bound;
    std::vector<Level> levels;   // Of detail, the finest first.
    std::vector<double> errors;  // Of theirs [m].
    bool placed{false};
    const Level* shown{nullptr};  // The one in use, of what is placed.
    bool crosses_near{false};  // May reach the plane through the camera: no rays to its vertices.
    Eigen::Isometry3d X_CB{Eigen::Isometry3d::Identity()};
    Eigen::Vector3d centre_C{Eigen::Vector3d::Zero()};
    RayBounds seen;  // Holds the rays to its vertices.
  };

  // An occluder as it is seen.
  struct SeenOccluder {
    double size;  // Of its bounds within what is asked for.
    SweptEllipsoid solid_C;
    RayBounds seen;
    const Mesh* own;  // The mesh that it hides nothing of, if any.
  };

  // A mesh that is drawn. `solid`: what of it hides what is behind it is that of this one.
  void Add(int frame, const TriangleMesh& mesh, const Eigen::Vector3f& colour,
           const TriangleMesh* solid);
  Level Store(const TriangleMesh& mesh);
  void ChooseDetail(Mesh* mesh) const;
  void PlaceVertices(Mesh* mesh, const Eigen::Vector3d& light_B, const Eigen::Vector3d& up_B,
                     LitVertex* vertices);
  void FindOccludersInUse(const std::vector<RayBounds>& bounds);
  void HideBehindParts(const std::vector<RayBounds>& bounds);
  void FindFacing(const Mesh& mesh, const Eigen::Vector3d& eye_B);

  CameraModel camera_;
  Light light_;
  Shortcuts shortcuts_;
  double near_;
  bool bent_;
  std::vector<Mesh> meshes_;

  // A structure of arrays over all bodies, in their own frames.
  std::vector<float> x_, y_, z_, nx_, ny_, nz_;
  std::vector<std::uint32_t> corners_;                        // Three to a triangle.
  std::vector<float> plane_x_, plane_y_, plane_z_, plane_d_;  // Of each triangle: n · p - d.

  // As seen now.
  std::vector<float> ray_x_, ray_y_;
  std::vector<std::uint8_t> facing_;   // Of each triangle.
  std::vector<std::uint32_t> hidden_;  // Of each vertex: one bit for each of the occluders in use.
  std::vector<SeenOccluder> occluders_;  // In use.
};

}  // namespace vantage::sim
