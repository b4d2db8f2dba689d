#include "sim/render/floor_tiles.h"

#include <cmath>
#include <cstddef>
#include <random>

#include <gtest/gtest.h>

#include "toy_scene.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(FloorTiles, AreEveryOtherSquare) {
  Floor floor;
  floor.reach = 1.2;
  const TriangleMesh mesh = DarkTiles(floor);
  EXPECT_EQ(mesh.triangles(), 2 * 18);  // Six tiles each way.
  for (const Eigen::Vector3f& p : mesh.vertices) EXPECT_LE(p.cwiseAbs().maxCoeff(), 1.5F);
  floor.visible = false;
  EXPECT_EQ(DarkTiles(floor).triangles(), 0);
  EXPECT_EQ(TilesSeen(floor, test::LookAt({0, 0, 2}, {0.1, 0, 0}), {-1, 1, -1, 1}).count, 0U);
}

// Wherever a ray of the window meets a dark tile, that tile is among those that are seen.
TEST(FloorTiles, ThatAWindowShowsAreAmongThoseSeen) {
  Floor floor;
  floor.height = -0.1;
  const TriangleMesh mesh = DarkTiles(floor);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int met = 0;
  std::size_t left_out = 0;
  for (int view = 0; view < 300; ++view) {
    const Vector3d eye(2.0 * uniform(random), 2.0 * uniform(random), 1.2 + uniform(random));
    const Vector3d target(2.0 * uniform(random), 2.0 * uniform(random), 0.4 * uniform(random));
    const Isometry3d X_WC = test::LookAt(eye, target, 3.0 * uniform(random));
    const Vector2d middle(0.5 * uniform(random), 0.4 * uniform(random));
    const double half = 0.01 + 0.3 * std::abs(uniform(random));
    const RayBounds bounds{middle.x() - half, middle.x() + half, middle.y() - half,
                           middle.y() + half};
    const IndexRange seen = TilesSeen(floor, X_WC, bounds);
    ASSERT_LE(seen.first + seen.count, mesh.indices.size());
    left_out += mesh.indices.size() - seen.count;
    for (int k = 0; k < 40; ++k) {
      const Vector3d ray = X_WC.linear() * Vector3d(middle.x() + half * uniform(random),
                                                    middle.y() + half * uniform(random), 1.0);
      if (ray.z() >= 0.0) continue;
      const Vector3d at = eye + (floor.height - eye.z()) / ray.z() * ray;
      for (std::size_t i = 0; i < mesh.indices.size(); i += 6) {  // Two triangles to a tile.
        Eigen::AlignedBox2f tile;
        for (std::size_t c = 0; c < 6; ++c) {
          tile.extend(mesh.vertices[mesh.indices[i + c]].head<2>());
        }
        if (!tile.contains(at.head<2>().cast<float>())) continue;
        ++met;
        ASSERT_TRUE(seen.first <= i && i < seen.first + seen.count) << "view " << view;
      }
    }
  }
  EXPECT_GT(met, 2000);
  EXPECT_GT(left_out, 300 * mesh.indices.size() / 4);
}

}  // namespace
}  // namespace vantage::sim
