#include "sim/render/tag_bodies.h"

#include <opencv2/core.hpp>
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
#include <opencv2/objdetect/aruco_dictionary.hpp>
#else
#include <opencv2/aruco.hpp>
#endif

#include "vantage/math/error.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kCells = 8;  // Six of data and a black one on each side.

// One byte a cell, row by row from the top: 0 is black.
cv::Mat CellsOf(int id) {
  if (id < 0 || id > kMaxTagId) {
    throw ConfigError(
        "", "tags.id",
        "must be in [0, " + std::to_string(kMaxTagId) + "], is " + std::to_string(id));
  }
  cv::Mat cells;
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
  cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11)
      .generateImageMarker(id, kCells, cells, 1);
#else
  cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11)
      ->drawMarker(id, kCells, cells, 1);
#endif
  // OpenCV's pictures of this family stand on their heads, compared with AprilTag's own.
  cv::rotate(cells, cells, cv::ROTATE_180);
  return cells;
}

}  // namespace

void AddTags(const std::vector<Tag>& tags, Scene* scene) {
  for (const Tag& tag : tags) {
    const cv::Mat cells = CellsOf(tag.id);
    const double cell = tag.size / kCells;
    // The paper is the plate's face: the ink lies in the plane of the corners, a little before it.
    const double ink = 0.004 * tag.size;
    TriangleMesh plate;
    Isometry3d X_TP = Isometry3d::Identity();
    X_TP.translation().z() = -0.03 * tag.size - ink;
    Append(&plate, BoxMesh({1.3 * tag.size, 1.3 * tag.size, 0.06 * tag.size}), tag.X_FT * X_TP);
    TriangleMesh black;
    for (int row = 0; row < kCells; ++row) {
      // Cells in a row that are black together are one rectangle.
      for (int first = 0; first < kCells; ++first) {
        if (cells.at<std::uint8_t>(row, first) != 0) continue;
        int last = first;
        while (last + 1 < kCells && cells.at<std::uint8_t>(row, last + 1) == 0) ++last;
        const double top = 0.5 * tag.size - row * cell;
        const double bottom = top - cell;
        const double left = -0.5 * tag.size + first * cell;
        const double right = -0.5 * tag.size + (last + 1) * cell;
        AppendQuad(
            &black,
            {{{left, bottom, 0.0}, {right, bottom, 0.0}, {right, top, 0.0}, {left, top, 0.0}}},
            Vector3d::UnitZ());
        first = last;
      }
    }
    TriangleMesh ink_mesh;
    Append(&ink_mesh, black, tag.X_FT);
    scene->bodies.push_back({kToolFrame, std::move(plate), {0.95F, 0.95F, 0.95F}, 0.0F});
    scene->bodies.push_back({kToolFrame, std::move(ink_mesh), {0.04F, 0.04F, 0.04F}, 0.0F});
    const Isometry3d X_FP = tag.X_FT * X_TP;
    if (X_FP.translation().norm() > 0.2 * tag.size) {
      // The strut's round end stays within the plate.
      const double strut = 0.08 * tag.size;
      const Vector3d foot = X_FP * Vector3d(0.0, 0.0, -strut);
      scene->bodies.push_back({kToolFrame,
                               CapsuleMesh(Vector3d::Zero(), foot, strut, 10),
                               {0.24F, 0.26F, 0.29F},
                               0.15F});
    }
  }
}

}  // namespace vantage::sim
