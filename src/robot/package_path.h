#pragma once

#include <string>
#include <vector>

/// @file
/// Private to the module: where the mesh files that a URDF names are.

namespace vantage {

/// A file name of a URDF file: package://name/..., model://name/..., file://..., an absolute path, or
/// one relative to the URDF file.
struct MeshLocation {
  std::string path;             ///< Of an existing file; empty: there is none.
  std::string reason_missing;   ///< Why path is empty.
  std::string missing_package;  ///< Its name, when that is why.
};

[[nodiscard]] MeshLocation FindMesh(const std::string& file_name, const std::string& urdf_path,
                                    const std::vector<std::string>& package_folders);

}  // namespace vantage
