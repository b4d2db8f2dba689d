#include "vantage/vision/visp_dot.h"

#include <vector>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "synthetic.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Vector2d;

MarkerPrediction At(const Vector2d& pixel, double radius, bool dark) {
  MarkerPrediction prediction;
  prediction.id = 7;
  prediction.dark = dark;
  prediction.expected = true;
  prediction.image.centre = prediction.image.centroid = pixel;
  prediction.image.shape = test::Shape(radius, radius, 0.0);
  prediction.image.area = kPi * radius * radius;
  return prediction;
}

TEST(DetectWithVispDot, FindsDotsOfBothPolarities) {
  for (const bool dark : {true, false}) {
    GreyImage image = test::Blank();
    const Vector2d centre(80.3, 60.6);
    test::DrawDot(&image, centre, test::Shape(9.0, 9.0, 0.0), dark);
    MarkerDetections detections;
    DetectWithVispDot(View(image), CameraModel(), {At(centre + Vector2d(2.0, 1.0), 9.0, dark)}, {},
                      &detections);
    ASSERT_EQ(detections.size(), 1U);
    EXPECT_EQ(detections[0].id, 7);
    ASSERT_TRUE(detections[0].valid()) << Name(detections[0].fault);
    EXPECT_TRUE(test::Near(detections[0].centroid, centre, 0.15));
  }
}

TEST(DetectWithVispDot, RefusesAnEmptyPlaceAndAnotherSize) {
  GreyImage image = test::Blank();
  MarkerDetections detections;
  DetectWithVispDot(View(image), CameraModel(), {At({80.0, 60.0}, 9.0, true)}, {}, &detections);
  EXPECT_FALSE(detections[0].valid());
  test::DrawDot(&image, {80.0, 60.0}, test::Shape(9.0, 9.0, 0.0), true);
  DetectWithVispDot(View(image), CameraModel(), {At({80.0, 60.0}, 6.0, true)}, {}, &detections);
  EXPECT_EQ(detections[0].fault, MarkerFault::kWrongArea);
}

TEST(DetectWithVispDot, TakesImagesWithGapsBetweenRows) {
  GreyImage image = test::Blank();
  test::DrawDot(&image, {60.0, 60.0}, test::Shape(9.0, 9.0, 0.0), true);
  const GreyView left{image.pixels.data(), 120, image.height, image.width};
  MarkerDetections detections;
  DetectWithVispDot(left, CameraModel(), {At({60.0, 60.0}, 9.0, true)}, {}, &detections);
  EXPECT_TRUE(detections[0].valid());
}

}  // namespace
}  // namespace vantage
