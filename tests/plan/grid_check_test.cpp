#include "vantage/plan/grid_check.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "cell.h"

namespace vantage::test {
namespace {

// Several blocks, the last of them not full.
constexpr std::int64_t kCameras = 60000;

std::vector<double> NumbersOf(const GridBest& best) {
  std::vector<double> numbers;
  for (const GridCamera& camera : best.cameras()) {
    numbers.insert(numbers.end(), {static_cast<double>(camera.index),
                                   static_cast<double>(camera.cell), camera.score});
  }
  return numbers;
}

// Cameras with equal scores among them, in fewer and in more cells than are kept.
std::vector<GridCamera> SomeCameras(int cells) {
  std::mt19937_64 random(3);
  std::vector<GridCamera> cameras;
  for (int i = 0; i < 4000; ++i) {
    cameras.push_back({i, random() % cells, static_cast<double>(random() % 700)});
  }
  return cameras;
}

TEST(GridBest, IsTheBestOfEachOfTheBestCellsInAnyOrder) {
  for (const int cells : {100, 1000}) {
    std::vector<GridCamera> cameras = SomeCameras(cells);
    // By definition: sorted, the first of each cell, as many as there may be.
    std::vector<GridCamera> sorted = cameras;
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const GridCamera& a, const GridCamera& b) { return a.score > b.score; });
    std::vector<std::int64_t> expected;
    std::set<std::uint64_t> taken;
    for (const GridCamera& camera : sorted) {
      if (expected.size() < GridBest::kMost && taken.insert(camera.cell).second) {
        expected.push_back(camera.index);
      }
    }
    for (int order = 0; order < 3; ++order) {
      std::shuffle(cameras.begin(), cameras.end(), std::mt19937_64(order));
      GridBest best;
      for (const GridCamera& camera : cameras) best.Offer(camera);
      std::vector<std::int64_t> kept;
      for (const GridCamera& camera : best.cameras()) kept.push_back(camera.index);
      EXPECT_EQ(kept, expected) << cells << " cells, order " << order;
    }
  }
}

TEST(GridBest, OfPartsIsThatOfTheWhole) {
  const std::vector<GridCamera> cameras = SomeCameras(1000);
  GridBest whole, joined;
  for (const GridCamera& camera : cameras) whole.Offer(camera);
  for (int part = 4; part >= 0; --part) {
    GridBest own;
    for (std::size_t i = part; i < cameras.size(); i += 5) own.Offer(cameras[i]);
    for (const GridCamera& camera : own.cameras()) joined.Offer(camera);
  }
  EXPECT_EQ(NumbersOf(joined), NumbersOf(whole));
  EXPECT_EQ(whole.cameras().size(), GridBest::kMost);
  EXPECT_FALSE(joined.Offer(whole.cameras().front()));  // once is enough
}

// A square plate, of half an edge `half` [m], that hides the work from where the view is best.
PlacementProblem WithAPlate(double half) {
  PlacementProblem problem = PumaProblem(6);
  const PlacedCamera open = PlaceCamera(PlacementModel(problem)).best;
  BatchBox plate;
  plate.X_WB = open.X_WC;
  plate.X_WB.translation() += 0.3 * open.X_WC.linear().col(2);
  plate.half = {half, half, 0.005};
  problem.limits.boxes = {plate};
  return problem;
}

SearchedGrid SearchInParts(const PlacementModel& model, int parts) {
  SearchedGrid grid;
  grid.cameras = kCameras;
  for (int part = parts - 1; part >= 0; --part) {
    GridSearch search(model, kCameras);
    for (int block = part; block < GridSearch::BlocksOf(kCameras); block += parts) {
      for (const GridCamera& camera : search.Search(block)) grid.best.Offer(camera);
    }
  }
  return grid;
}

TEST(GridSearch, IsTheSameToTheLastBitHoweverItIsCut) {
  for (PlacementProblem problem : {PumaProblem(3), WithAPlate(0.01)}) {
    const PlacementModel model(std::move(problem));
    ASSERT_NE(model.obstacles(), nullptr);
    ASSERT_GT(GridSearch::BlocksOf(kCameras), 7);
    const PlacedCamera result = PlaceCamera(model).best;
    const SearchedGrid whole = SearchInParts(model, 1);
    ASSERT_EQ(whole.best.cameras().size(), GridBest::kMost);
    const GridCheck check = CheckAgainstGrid(model, result, kCameras);
    ASSERT_TRUE(check.best.feasible);
    for (const int parts : {3, 7}) {
      const SearchedGrid cut = SearchInParts(model, parts);
      EXPECT_EQ(NumbersOf(cut.best), NumbersOf(whole.best)) << parts << " parts";
      const GridCheck joined = FinishGridCheck(model, result, cut);
      EXPECT_EQ(joined.best_on_grid, check.best_on_grid);
      EXPECT_EQ(joined.best.q_c, check.best.q_c);
      EXPECT_EQ(joined.gap, check.gap);
    }
  }
}

TEST(GridSearch, KeepsCamerasThatSeeWhatTheyMustWhereTheBestSeeNothing) {
  // Hardly a camera of the grid sees past it.
  const PlacementModel model(WithAPlate(0.03));
  PlacementProblem problem = model.problem();
  problem.limits.boxes.clear();
  const PlacementModel open(std::move(problem));
  const PlacedCamera result = PlaceCamera(model).best;
  const GridCheck check = CheckAgainstGrid(model, result, kCameras);
  EXPECT_TRUE(JudgeCamera(model, check.best.q_c).feasible);
  EXPECT_LT(check.gap, 1e-6);
  EXPECT_GT(CheckAgainstGrid(open, result, kCameras).best_on_grid, check.best_on_grid);
}

TEST(GridSearch, OfCamerasWithoutViewKeepsNone) {
  PlacementProblem problem = PumaProblem(6, 16);
  problem.limits.depth = {50.0, 60.0};
  const PlacementModel model(std::move(problem));
  const GridCheck check = CheckAgainstGrid(model, PlacedCamera(), 1000);
  EXPECT_FALSE(check.best.feasible);
  EXPECT_EQ(check.best_on_grid, -INFINITY);
  EXPECT_EQ(check.gap, -INFINITY);
}

TEST(GridSearch, OfACameraThatIsFixedIsThatCamera) {
  PlacementProblem problem = PumaProblem(6, 16);
  const PlacedCamera sphere = PlaceCamera(PlacementModel(problem)).best;
  problem.rig = CameraRig();
  problem.rig.X_WC_fixed = sphere.X_WC;
  problem.q_c_start.resize(0);
  const PlacementModel model(std::move(problem));
  const GridCheck check = CheckAgainstGrid(model, sphere, 1000);
  ASSERT_TRUE(check.best.feasible);
  EXPECT_NEAR(check.gap, 0.0, 1e-12);
}

}  // namespace
}  // namespace vantage::test
