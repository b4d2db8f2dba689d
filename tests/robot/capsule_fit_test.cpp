#include "vantage/robot/capsule_fit.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

double Outside(const CapsuleShape& capsule, const Vector3d& p) {
  const Vector3d along = capsule.p_B - capsule.p_A;
  const double length2 = along.squaredNorm();
  const double s =
      length2 > 0.0 ? std::clamp((p - capsule.p_A).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - capsule.p_A - s * along).norm() - capsule.radius;
}

double WorstOutside(const CapsuleShape& capsule, const std::vector<Vector3d>& points) {
  double worst = -1e9;
  for (const Vector3d& p : points) worst = std::max(worst, Outside(capsule, p));
  return worst;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vector3d InBox(const Vector3d& half) {
    return {Uniform(-half.x(), half.x()), Uniform(-half.y(), half.y()),
            Uniform(-half.z(), half.z())};
  }
  Vector3d Direction() {
    Vector3d d;
    do {
      d = InBox(Vector3d::Ones());
    } while (d.norm() > 1.0 || d.norm() < 0.1);
    return d.normalized();
  }
  Isometry3d Pose() {
    Isometry3d X = Isometry3d::Identity();
    X.linear() = Eigen::AngleAxisd(Uniform(0.0, 3.0), Direction()).toRotationMatrix();
    X.translation() = InBox(Vector3d::Ones());
    return X;
  }

 private:
  std::mt19937 engine_;
};

TriangleSurface Box(const Vector3d& low, const Vector3d& high) {
  TriangleSurface surface;
  for (int i = 0; i < 8; ++i) {
    surface.points.emplace_back((i & 1) != 0 ? high.x() : low.x(),
                                (i & 2) != 0 ? high.y() : low.y(),
                                (i & 4) != 0 ? high.z() : low.z());
  }
  const std::array<std::array<std::uint32_t, 3>, 12> triangles{{{0, 2, 3},
                                                                {0, 3, 1},
                                                                {4, 5, 7},
                                                                {4, 7, 6},
                                                                {0, 1, 5},
                                                                {0, 5, 4},
                                                                {2, 6, 7},
                                                                {2, 7, 3},
                                                                {0, 4, 6},
                                                                {0, 6, 2},
                                                                {1, 3, 7},
                                                                {1, 7, 5}}};
  surface.triangles.assign(triangles.begin(), triangles.end());
  return surface;
}

void Append(TriangleSurface* surface, const TriangleSurface& other) {
  const auto first = static_cast<std::uint32_t>(surface->points.size());
  surface->points.insert(surface->points.end(), other.points.begin(), other.points.end());
  for (const auto& t : other.triangles) {
    surface->triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
}

// Points of the surface between its corners.
std::vector<Vector3d> Sampled(const TriangleSurface& surface) {
  std::vector<Vector3d> points;
  constexpr int kSteps = 12;
  for (const auto& t : surface.triangles) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const double a = static_cast<double>(i) / kSteps;
        const double b = static_cast<double>(j) / kSteps;
        points.push_back(surface.points[t[0]] + a * (surface.points[t[1]] - surface.points[t[0]]) +
                         b * (surface.points[t[2]] - surface.points[t[0]]));
      }
    }
  }
  return points;
}

double WorstOutsideOfAll(const std::vector<CapsuleShape>& capsules,
                         const std::vector<Vector3d>& points) {
  double worst = -1e9;
  for (const Vector3d& p : points) {
    double nearest = 1e9;
    for (const CapsuleShape& capsule : capsules) nearest = std::min(nearest, Outside(capsule, p));
    worst = std::max(worst, nearest);
  }
  return worst;
}

double TotalVolume(const std::vector<CapsuleShape>& capsules) {
  double volume = 0.0;
  for (const CapsuleShape& capsule : capsules) volume += Volume(capsule);
  return volume;
}

TEST(Volume, IsThatOfACylinderAndABall) {
  EXPECT_NEAR(Volume({{0, 0, 0}, {0, 0, 2}, 0.5}), kPi * 0.25 * 2 + 4.0 / 3.0 * kPi * 0.125, 1e-14);
}

TEST(Contains, HoldsToTheSurface) {
  const CapsuleShape outer{{0, 0, 0}, {0, 0, 1}, 0.5};
  EXPECT_TRUE(Contains(outer, {{0, 0.3, 0.2}, {0.3, 0, 0.9}, 0.2}));
  EXPECT_FALSE(Contains(outer, {{0, 0.3, 0.2}, {0.3, 0, 0.9}, 0.201}));
  EXPECT_FALSE(Contains(outer, {{0, 0, 0}, {0, 0, 1.31}, 0.2}));
  EXPECT_FALSE(Contains(outer, {{0, 0, 0}, {0, 0, 0}, 0.6}));
}

TEST(FitCapsule, HoldsEveryPoint) {
  Random random(1);
  for (int trial = 0; trial < 60; ++trial) {
    // From needles to discs, few points and many.
    const Vector3d half(random.Uniform(0.001, 1.0), random.Uniform(0.001, 1.0),
                        random.Uniform(0.001, 1.0));
    const Isometry3d X = random.Pose();
    std::vector<Vector3d> points;
    const int count = trial % 3 == 0 ? 4 : trial % 3 == 1 ? 100 : 2000;
    for (int i = 0; i < count; ++i) points.push_back(X * random.InBox(half));
    const CapsuleShape capsule = FitCapsule(points);
    EXPECT_LE(WorstOutside(capsule, points), 1e-9) << trial;
    EXPECT_GT(WorstOutside(capsule, points), -1e-4) << trial;  // Some point touches it.
  }
}

// Points on a capsule's surface: there is no smaller one round them but for the gaps between them.
TEST(FitCapsule, FindsTheCapsuleThePointsLieOn) {
  Random random(2);
  for (int trial = 0; trial < 12; ++trial) {
    const Isometry3d X = random.Pose();
    const double radius = random.Uniform(0.03, 0.2);
    const double half = random.Uniform(0.3 * radius, 0.6);
    std::vector<Vector3d> points;
    for (int i = 0; i < 3000; ++i) {
      const Vector3d d = random.Direction();
      const Vector3d side = radius * Vector3d(d.x(), d.y(), 0.0).normalized();
      const Vector3d cap = radius * d + Vector3d(0, 0, d.z() > 0.0 ? half : -half);
      points.push_back(X * (i % 2 == 0 ? cap : side + Vector3d(0, 0, random.Uniform(-half, half))));
    }
    const double true_volume = Volume({{0, 0, -half}, {0, 0, half}, radius});
    const CapsuleShape capsule = FitCapsule(points);
    EXPECT_LE(WorstOutside(capsule, points), 1e-9);
    EXPECT_LT(Volume(capsule), 1.01 * true_volume) << trial;
    EXPECT_GT(Volume(capsule), 0.97 * true_volume) << trial;
    EXPECT_NEAR(capsule.radius, radius, 0.02 * radius);
  }
}

// Against a search that tries axes all over the sphere through the middle of the points.
TEST(FitCapsule, IsNoWorseThanAnyAxisTried) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Isometry3d X = random.Pose();
    const Vector3d half(0.5, random.Uniform(0.05, 0.5), random.Uniform(0.05, 0.5));
    std::vector<Vector3d> points;
    for (int i = 0; i < 8; ++i) {
      points.push_back(X * half.cwiseProduct(Vector3d((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1,
                                                      (i & 4) != 0 ? 1 : -1)));
    }
    double least = 1e9;
    for (int k = 0; k < 4000; ++k) {
      const Vector3d d = random.Direction();
      double radius = 0.0;
      for (const Vector3d& p : points) {
        radius = std::max(radius, d.cross(p - X.translation()).norm());
      }
      double reach = 0.0;
      for (const Vector3d& p : points) {
        const double across = d.cross(p - X.translation()).norm();
        reach = std::max(reach, std::abs(d.dot(p - X.translation())) -
                                    std::sqrt(std::max(0.0, radius * radius - across * across)));
      }
      least = std::min(least, Volume({-reach * d, reach * d, radius}));
    }
    EXPECT_LT(Volume(FitCapsule(points)), 1.001 * least) << trial;
  }
}

TEST(FitCapsule, TakesDegeneratePoints) {
  const CapsuleShape ball = FitCapsule({{1, 2, 3}});
  EXPECT_EQ(ball.p_A, Vector3d(1, 2, 3));
  EXPECT_EQ(ball.p_B, Vector3d(1, 2, 3));
  EXPECT_GT(ball.radius, 0.0);

  const std::vector<Vector3d> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  const CapsuleShape thin = FitCapsule(line);
  EXPECT_LE(WorstOutside(thin, line), 1e-12);
  EXPECT_LT(thin.radius, 1e-2);

  const std::vector<Vector3d> twice{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  EXPECT_LE(WorstOutside(FitCapsule(twice), twice), 0.0);
}

TEST(FitCapsule, GivesTheSameEachTime) {
  Random random(4);
  std::vector<Vector3d> points;
  for (int i = 0; i < 500; ++i) points.push_back(random.InBox({0.5, 0.2, 0.1}));
  const CapsuleShape a = FitCapsule(points);
  const CapsuleShape b = FitCapsule(points);
  EXPECT_EQ(a.p_A, b.p_A);
  EXPECT_EQ(a.p_B, b.p_B);
  EXPECT_EQ(a.radius, b.radius);
}

TEST(FitCapsuleToCylinder, HoldsTheRimsAndIsTheSmallest) {
  for (const auto& [radius, length] :
       {std::pair{0.05, 0.5}, {0.05, 0.1}, {0.05, 0.01}, {0.3, 0.02}}) {
    const CapsuleShape capsule = FitCapsuleToCylinder(radius, length);
    std::vector<Vector3d> rims;
    for (int i = 0; i < 720; ++i) {
      const double angle = kPi * i / 360.0;
      for (const double z : {-0.5 * length, 0.5 * length}) {
        rims.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
      }
    }
    EXPECT_NEAR(WorstOutside(capsule, rims), 0.0, 1e-9);
    // No capsule on the axis is smaller, and none at all by more than the gaps between the points.
    for (double a = 0.0; a <= 0.5 * length; a += 0.001 * length) {
      EXPECT_LE(
          Volume(capsule),
          Volume({{0, 0, -a}, {0, 0, a}, std::hypot(radius, 0.5 * length - a)}) * (1.0 + 1e-8));
    }
    EXPECT_LT(Volume(capsule), 1.001 * Volume(FitCapsule(rims)));
  }
}

TEST(FitCapsules, CutsAnL) {
  TriangleSurface surface = Box({0.0, -0.04, -0.04}, {0.5, 0.04, 0.04});
  Append(&surface, Box({0.42, -0.04, 0.04}, {0.5, 0.04, 0.5}));
  const std::vector<CapsuleShape> one = FitCapsules(surface, 1);
  const std::vector<CapsuleShape> two = FitCapsules(surface, 2);
  ASSERT_EQ(one.size(), 1u);
  ASSERT_EQ(two.size(), 2u);
  const std::vector<Vector3d> samples = Sampled(surface);
  EXPECT_LE(WorstOutsideOfAll(one, samples), 1e-9);
  EXPECT_LE(WorstOutsideOfAll(two, samples), 1e-9);
  EXPECT_LT(TotalVolume(two), 0.25 * TotalVolume(one));
}

TEST(FitCapsules, CutsAU) {
  TriangleSurface surface = Box({0.0, -0.03, -0.03}, {0.5, 0.03, 0.03});
  Append(&surface, Box({0.0, -0.03, 0.03}, {0.06, 0.03, 0.5}));
  Append(&surface, Box({0.44, -0.03, 0.03}, {0.5, 0.03, 0.5}));
  const std::vector<CapsuleShape> parts = FitCapsules(surface, 4);
  EXPECT_GE(parts.size(), 3u);
  EXPECT_LE(parts.size(), 4u);
  EXPECT_LE(WorstOutsideOfAll(parts, Sampled(surface)), 1e-9);
  double widest = 0.0;
  for (const CapsuleShape& capsule : parts) widest = std::max(widest, capsule.radius);
  EXPECT_LT(widest, 0.07);
}

TEST(FitCapsules, LeavesARodWhole) {
  EXPECT_EQ(FitCapsules(Box({-0.04, -0.04, -0.5}, {0.04, 0.04, 0.5}), 3).size(), 1u);
}

// The parts of triangles that a cut runs through stay covered, also where there is no corner.
TEST(FitCapsules, CoversRandomTriangles) {
  Random random(5);
  for (int trial = 0; trial < 15; ++trial) {
    TriangleSurface surface;
    for (std::uint32_t i = 0; i < 10; ++i) {
      for (int k = 0; k < 3; ++k) surface.points.push_back(random.InBox({0.6, 0.4, 0.1}));
      surface.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const std::vector<CapsuleShape> capsules = FitCapsules(surface, 4, 0.99);
    EXPECT_LE(WorstOutsideOfAll(capsules, Sampled(surface)), 1e-9) << trial;
  }
}

// A large surface is cut where a part of its triangles says, but every one is covered.
TEST(FitCapsules, CoversALargeSurface) {
  TriangleSurface surface;
  constexpr int kRings = 120;
  constexpr int kSides = 40;
  for (int i = 0; i <= kRings; ++i) {
    const double s = 0.5 * kPi * i / kRings;  // A quarter of a torus.
    for (int j = 0; j < kSides; ++j) {
      const double t = 2.0 * kPi * j / kSides;
      const double out = 0.4 + 0.05 * std::cos(t);
      surface.points.emplace_back(out * std::cos(s), out * std::sin(s), 0.05 * std::sin(t));
    }
  }
  for (std::uint32_t i = 0; i < kRings; ++i) {
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const std::uint32_t a = i * kSides + j;
      const std::uint32_t b = i * kSides + (j + 1) % kSides;
      surface.triangles.push_back({a, b, b + kSides});
      surface.triangles.push_back({a, b + kSides, a + kSides});
    }
  }
  const std::vector<CapsuleShape> capsules = FitCapsules(surface, 3);
  EXPECT_GE(capsules.size(), 2u);
  EXPECT_LE(WorstOutsideOfAll(capsules, surface.points), 1e-9);
  EXPECT_LT(TotalVolume(capsules), 0.85 * Volume(FitCapsule(surface.points)));
}

}  // namespace
}  // namespace vantage
