#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sim/render/mesh.h"
#include "vantage/features/marker.h"
#include "vantage/robot/arm_model.h"
#include "vantage/robot/kinematics.h"

/// @file
/// What the simulated camera looks at: constant data in Scene, what moves in SceneState.

namespace vantage::sim {

/// Frames that things are fixed to, besides the links 0..n-1.
inline constexpr int kWorldFrame = -1;  ///< W.
inline constexpr int kToolFrame = -2;   ///< The end effector's frame E.
inline constexpr int kGoalFrame = -3;   ///< The goal's: W, unless the goal moves.

/// One rigid mesh of one colour.
struct Body {
  int frame{kWorldFrame};  ///< Link index, or one of the frames above: the frame of the mesh.
  TriangleMesh mesh;
  Eigen::Vector3f colour{0.5F, 0.5F, 0.5F};  ///< Red, green, blue; 0 to 1.
  float gloss{0.2F};  ///< Strength of the highlight in colour images; 0 to 1.
};

/// A round dot of the scene with the frame it is fixed to.
struct SceneMarker {
  int frame{kToolFrame};
  Marker marker;  ///< Centre and normal in that frame.
  /// Colour of the thin round plate that it is glued on; without one it is painted on a body.
  std::optional<Eigen::Vector3f> plate{};
};

/// A horizontal floor, seen from above only: a faint chequer on the background, fading with distance.
struct Floor {
  bool visible{true};
  double height{0.0};  ///< z in W [m].
  double tile{0.5};    ///< Edge of a tile [m]; > 0.
  double reach{3.0};  ///< Tiles are drawn this far from W's z axis [m]; at most 200 tiles each way.
  float contrast{0.03F};  ///< How much darker every other tile is than the background.
};

struct Light {
  Eigen::Vector3f direction_W{Eigen::Vector3f(0.35F, -0.45F, 0.82F)};  ///< Towards the light.
  float ambient{0.45F};  ///< Of a surface in the shade.
};

/// What grey images leave out for speed. Without, the image comes from more triangles: to compare with.
struct Shortcuts {
  bool hidden{true};  ///< Triangles wholly behind one part of a body. Changes no pixel.
  double detail{
      0.5};  ///< Meshes are as coarse as is within this in the image [px]; 0: as they are.
};

/// Constant part of a scene.
struct Scene {
  std::vector<Body> bodies;
  std::vector<SceneMarker> markers;  ///< At most kMaxMarkers.
  /// Capsules of the arm. A marker whose centre lies in one is drawn on its outside, as if it were
  /// painted on: capsules are fitted round bodies and often stick out where markers are glued on.
  std::vector<Capsule> capsules;
  Floor floor;
  Light light;
  float background{0.47F};  ///< Brightness behind everything; 0 to 1.
  float dark{0.10F};        ///< Brightness of dark discs and dark rings.
  float bright{0.90F};      ///< Brightness of bright discs and bright rings.
  Shortcuts shortcuts;
};

/// What moves.
struct SceneState {
  LinkPoses X_WL{};                                       ///< Poses of the links.
  Eigen::Isometry3d X_WE{Eigen::Isometry3d::Identity()};  ///< Pose of the end effector.
  Eigen::Isometry3d X_WG{Eigen::Isometry3d::Identity()};  ///< Pose of the goal's frame.

  SceneState() { X_WL.fill(Eigen::Isometry3d::Identity()); }
  SceneState(const LinkPoses& links, const Eigen::Isometry3d& tool,
             const Eigen::Isometry3d& goal = Eigen::Isometry3d::Identity())
      : X_WL(links), X_WE(tool), X_WG(goal) {}
};

/// Pose of a frame of the scene in W.
/// @pre frame is kWorldFrame, kToolFrame, kGoalFrame or in [0, kMaxJoints).
[[nodiscard]] Eigen::Isometry3d FramePose(const SceneState& state, int frame) noexcept;

/// The plate of a marker, in the frame that the marker is fixed to. Its face, of kPlateRadii radii, lies a little behind
/// the marker.
[[nodiscard]] TriangleMesh MarkerPlate(const Marker& marker);

/// Nearly the same plate from fewer triangles, with a sharp edge and its face in the marker's plane; those of its face
/// are the last kPlainPlateSides.
[[nodiscard]] TriangleMesh PlainMarkerPlate(const Marker& marker);
inline constexpr int kPlainPlateSides = 20;

}  // namespace vantage::sim
