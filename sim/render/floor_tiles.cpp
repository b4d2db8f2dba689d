#include "sim/render/floor_tiles.h"

#include <algorithm>
#include <cmath>

namespace vantage::sim {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kIndicesPerTile = 6;
// The window is taken to be this much wider each way, for what rasterisers round [X/Z].
constexpr double kMargin = 1e-3;
// Rays that go down by less than this share of their length meet the floor too far away to tell where.
constexpr double kLeastFall = 1e-3;

// Tiles from W's z axis to the end, each way.
int TilesEachWay(const Floor& floor) {
  return std::min(200, static_cast<int>(std::ceil(floor.reach / floor.tile)));
}

}  // namespace

TriangleMesh DarkTiles(const Floor& floor) {
  TriangleMesh mesh;
  if (!floor.visible) return mesh;
  const int reach = TilesEachWay(floor);
  for (int i = -reach; i < reach; ++i) {
    for (int j = -reach; j < reach; ++j) {
      if ((i + j) % 2 != 0) continue;
      const auto corner = [&](int x, int y) {
        return Vector3d(x * floor.tile, y * floor.tile, floor.height);
      };
      AppendQuad(&mesh, {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)},
                 Vector3d::UnitZ());
    }
  }
  return mesh;
}

IndexRange TilesSeen(const Floor& floor, const Eigen::Isometry3d& X_WC, const RayBounds& bounds) {
  if (!floor.visible) return {};
  const int reach = TilesEachWay(floor);
  const auto column = kIndicesPerTile * static_cast<std::size_t>(reach);  // Half of 2 reach tiles.
  const IndexRange all{0, 2 * static_cast<std::size_t>(reach) * column};
  // What the window shows of the floor is convex: its corners bound it.
  double low = reach * floor.tile;
  double high = -low;
  for (const double x : {bounds.x0 - kMargin, bounds.x1 + kMargin}) {
    for (const double y : {bounds.y0 - kMargin, bounds.y1 + kMargin}) {
      const Vector3d ray = X_WC.linear() * Vector3d(x, y, 1.0);
      if (!(ray.z() < -kLeastFall * ray.norm())) return all;
      const double way = (floor.height - X_WC.translation().z()) / ray.z();
      const double at = X_WC.translation().x() + way * ray.x();
      low = std::min(low, at);
      high = std::max(high, at);
    }
  }
  const auto column_at = [&](double x) {
    return static_cast<std::size_t>(
        std::clamp(std::floor(x / floor.tile) + reach, 0.0, 2.0 * reach));
  };
  const std::size_t first = column_at(low);
  const std::size_t end = std::min(column_at(high) + 1, 2 * static_cast<std::size_t>(reach));
  return first < end ? IndexRange{first * column, (end - first) * column} : IndexRange{};
}

}  // namespace vantage::sim
