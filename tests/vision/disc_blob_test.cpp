#include "vantage/vision/disc_blob.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "eigen_matchers.h"
#include "synthetic.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using test::Blank;
using test::DrawBox;
using test::DrawDot;
using test::Shape;

DiscBlob Measure(const GreyImage& image, const Vector2d& seed, bool dark,
                 const DiscOptions& options = {}) {
  return MeasureDisc(View(image), {0, 0, image.width, image.height},
                     static_cast<int>(std::lround(seed.x())),
                     static_cast<int>(std::lround(seed.y())), dark, options);
}

class MeasureDiscOfBothPolarities : public ::testing::TestWithParam<bool> {};

TEST_P(MeasureDiscOfBothPolarities, FindsCentreAreaAndShape) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 40; ++i) {
    const double a = 9.0 + 5.0 * uniform(random);
    const double b = a * (0.75 + 0.25 * uniform(random));
    const Matrix2d shape = Shape(a, b, 2.0 * uniform(random));
    const Vector2d centre(80.0 + 5.0 * uniform(random), 60.0 + 5.0 * uniform(random));
    GreyImage image = Blank();
    DrawDot(&image, centre, shape, GetParam());
    const DiscBlob blob = Measure(image, centre, GetParam());
    ASSERT_EQ(blob.fault, MarkerFault::kNone) << Name(blob.fault) << " a " << a << " b " << b;
    EXPECT_TRUE(test::Near(blob.centroid, centre, 0.015));
    EXPECT_NEAR(blob.area / (kPi * a * b), 1.0, 0.01 + 0.5 / b / b);
    EXPECT_TRUE(test::Near(blob.shape, shape, 0.04 * a * a));
    EXPECT_NEAR(blob.contrast, test::kBright - test::kDark, 4.0);
  }
}

TEST_P(MeasureDiscOfBothPolarities, WorksFromAnyPixelOfTheDisc) {
  const Vector2d centre(80.3, 60.2);
  GreyImage image = Blank();
  DrawDot(&image, centre, Shape(10.0, 8.0, 0.4), GetParam());
  const DiscBlob reference = Measure(image, centre, GetParam());
  for (int i = 0; i < 12; ++i) {
    const Vector2d seed = centre + 6.0 * Vector2d(std::cos(i * kPi / 6.0), std::sin(i * kPi / 6.0));
    const DiscBlob blob = Measure(image, seed, GetParam());
    ASSERT_EQ(blob.fault, MarkerFault::kNone) << i;
    EXPECT_TRUE(test::Near(blob.centroid, reference.centroid, 1e-3));
  }
}

TEST_P(MeasureDiscOfBothPolarities, RefusesTheOtherPolarity) {
  GreyImage image = Blank();
  DrawDot(&image, {80.0, 60.0}, Shape(8.0, 8.0, 0.0), GetParam());
  EXPECT_NE(Measure(image, {80.0, 60.0}, !GetParam()).fault, MarkerFault::kNone);
}

INSTANTIATE_TEST_SUITE_P(Polarity, MeasureDiscOfBothPolarities, ::testing::Bool());

// Grey noise of 6 levels on a contrast of 205: centroids stay good, and the gates stay open.
TEST(MeasureDisc, StandsNoise) {
  double worst = 0.0;
  int refused = 0;
  for (unsigned i = 0; i < 50; ++i) {
    const Vector2d centre(80.0 + 0.02 * i, 60.0 - 0.013 * i);
    GreyImage image = Blank();
    DrawDot(&image, centre, Shape(8.0, 6.0, 0.1 * i), true);
    test::AddNoise(&image, 6.0, i);
    const DiscBlob blob = Measure(image, centre, true);
    refused += blob.fault == MarkerFault::kNone ? 0 : 1;
    if (blob.fault == MarkerFault::kNone) worst = std::max(worst, (blob.centroid - centre).norm());
  }
  EXPECT_EQ(refused, 0);
  EXPECT_LT(worst, 0.06);
}

// A blurred edge widens the second moments; that alone must not look like a covered disc. (Discs of less
// than six standard deviations of the blur lose contrast to it, and accuracy.)
TEST(MeasureDisc, StandsBlur) {
  for (const double sigma : {0.5, 1.0, 1.5}) {
    const Vector2d centre(80.2, 59.7);
    GreyImage image = Blank();
    DrawDot(&image, centre, Shape(11.0, 9.5, 0.4), true);
    cv::Mat pixels(image.height, image.width, CV_8U, image.pixels.data());
    cv::GaussianBlur(pixels, pixels, cv::Size(), sigma);
    const DiscBlob blob = Measure(image, centre, true);
    ASSERT_EQ(blob.fault, MarkerFault::kNone) << Name(blob.fault) << " at " << sigma;
    EXPECT_TRUE(test::Near(blob.centroid, centre, 0.02));
  }
}

TEST(MeasureDisc, StandsGainAndOffset) {
  const Vector2d centre(80.2, 59.7);
  GreyImage image = Blank();
  DrawDot(&image, centre, Shape(9.0, 7.0, 0.4), false);
  for (std::uint8_t& pixel : image.pixels) pixel = static_cast<std::uint8_t>(0.3 * pixel + 60.0);
  const DiscBlob blob = Measure(image, centre, false);
  ASSERT_EQ(blob.fault, MarkerFault::kNone);
  EXPECT_TRUE(test::Near(blob.centroid, centre, 0.02));
}

// A bar slides over the dot, of any grey: as soon as it hides more than a sliver of the disc, the disc
// is refused; before, it is where it was.
TEST(MeasureDisc, RefusesACoveredDisc) {
  const Vector2d centre(80.3, 60.1);
  const double a = 9.0;
  for (const int level : {10, 60, 120, 180, 245}) {
    for (const bool dark : {true, false}) {
      for (int bar = 0; bar <= 18; ++bar) {
        GreyImage image = Blank();
        DrawDot(&image, centre, Shape(a, a, 0.0), dark);
        DrawBox(&image, {0, 0, static_cast<int>(centre.x() - a) - 4 + bar, image.height},
                static_cast<std::uint8_t>(level));
        const DiscBlob blob = Measure(image, centre + Vector2d(2.0, 0.0), dark);
        const double hidden = bar - 4.3;  // Of the disc's width of 18 [px].
        if (hidden > 1.0) {
          EXPECT_NE(blob.fault, MarkerFault::kNone) << "bar " << bar << " level " << level;
        }
        if (blob.fault == MarkerFault::kNone) {
          EXPECT_TRUE(test::Near(blob.centroid, centre, 0.05))
              << "bar " << bar << " level " << level;
        }
      }
    }
  }
}

// A cable across the disc, its grey that of the ring.
TEST(MeasureDisc, RefusesADiscCutInTwo) {
  GreyImage image = Blank();
  DrawDot(&image, {80.0, 60.0}, Shape(10.0, 10.0, 0.0), true);
  DrawBox(&image, {78, 0, 3, image.height}, test::kBright);
  EXPECT_NE(Measure(image, {84.0, 60.0}, true).fault, MarkerFault::kNone);
}

TEST(MeasureDisc, RefusesADiscAtTheImageBorder) {
  for (int i = 0; i <= 20; ++i) {
    const Vector2d centre(0.5 * i, 60.0);
    GreyImage image = Blank();
    DrawDot(&image, centre, Shape(7.0, 7.0, 0.0), true);
    const DiscBlob blob = Measure(image, {std::max(centre.x(), 1.0), 60.0}, true);
    if (centre.x() < 7.5) {
      EXPECT_NE(blob.fault, MarkerFault::kNone) << centre.x();
    } else if (centre.x() > 9.4) {
      EXPECT_EQ(blob.fault, MarkerFault::kNone) << centre.x() << Name(blob.fault);
      EXPECT_TRUE(test::Near(blob.centroid, centre, 0.02));
    }
  }
}

TEST(MeasureDisc, NamesItsReason) {
  GreyImage image = Blank();
  EXPECT_EQ(Measure(image, {80.0, 60.0}, true).fault, MarkerFault::kNoContrast);
  DrawDot(&image, {80.0, 60.0}, Shape(9.0, 9.0, 0.0), true);
  const PixelWindow narrow{74, 30, 60, 60};
  EXPECT_EQ(MeasureDisc(View(image), narrow, 80, 60, true, {}).fault, MarkerFault::kNoContrast);
  DiscOptions options;
  options.max_semi_axis = 8.0;
  EXPECT_EQ(Measure(image, {80.0, 60.0}, true, options).fault, MarkerFault::kTooLarge);
  options = {};
  options.min_semi_axis = 10.0;
  EXPECT_EQ(Measure(image, {80.0, 60.0}, true, options).fault, MarkerFault::kTooSmall);
  DrawBox(&image, {92, 56, 30, 8}, 40);  // Hides a piece of the ring.
  EXPECT_EQ(Measure(image, {80.0, 60.0}, true).fault, MarkerFault::kWeakRing);
  GreyImage square = Blank(160, 120, 230);
  DrawBox(&square, {70, 50, 20, 20}, 25);
  EXPECT_EQ(Measure(square, {80.0, 60.0}, true).fault, MarkerFault::kNotElliptic);
}

TEST(MeasureDisc, RefusesASeedOutsideOfTheImage) {
  const GreyImage image = Blank();
  EXPECT_NE(Measure(image, {-3.0, 60.0}, true).fault, MarkerFault::kNone);
  EXPECT_NE(Measure(image, {80.0, 500.0}, true).fault, MarkerFault::kNone);
}

TEST(MeasureDisc, ReadsOnlyItsWindow) {
  GreyImage image = Blank();
  DrawDot(&image, {80.0, 60.0}, Shape(6.0, 6.0, 0.0), true);
  const PixelWindow window{60, 40, 41, 41};
  const DiscBlob before = MeasureDisc(View(image), window, 80, 60, true, {});
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      if (!window.contains(u, v))
        *image.at(u, v) = static_cast<std::uint8_t>((u * 7 + v * 13) % 256);
    }
  }
  const DiscBlob after = MeasureDisc(View(image), window, 80, 60, true, {});
  EXPECT_EQ(before.fault, MarkerFault::kNone);
  EXPECT_EQ(after.fault, MarkerFault::kNone);
  EXPECT_EQ(before.centroid, after.centroid);
}

}  // namespace
}  // namespace vantage
