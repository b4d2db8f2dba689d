#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "vantage/math/error.h"

/// @file
/// Triangle meshes from files.

namespace vantage {

/// A mesh file cannot be used. The message names the file and the reason.
class MeshError : public Error {
 public:
  /// @param path  Of the mesh. @param reason  What is wrong with it.
  MeshError(const std::string& path, const std::string& reason) : Error(path + ": " + reason) {}
};

/// Triangles of one colour.
struct MeshPart {
  std::vector<Eigen::Vector3f> vertices;  ///< In the file's axes, its unit applied [m].
  std::vector<Eigen::Vector3f> normals;   ///< Unit, one for each vertex.
  std::vector<std::uint32_t> indices;     ///< Three to a triangle, counter-clockwise from outside.
  std::optional<Eigen::Vector3f> colour;  ///< Red, green, blue; 0 to 1. None: the file has none.
};

/// Largest mesh that is read.
inline constexpr int kMaxMeshTriangles = 2'000'000;

/// Reads a mesh: STL, DAE, OBJ, and what else assimp knows by the file's extension.
///
/// A DAE's axes are taken as they are written, whatever its up axis says, as other readers of URDF
/// files do. Normals of STL files, and absent ones, are computed: edges of more than 40 degrees stay
/// sharp.
/// Throws MeshError when the file is missing, is no mesh, holds no triangle, one that is not finite or
/// more than kMaxMeshTriangles.
[[nodiscard]] std::vector<MeshPart> ReadMeshFile(const std::string& path);

}  // namespace vantage
