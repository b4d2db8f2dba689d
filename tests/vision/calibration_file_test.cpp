#include "vantage/vision/calibration_file.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <visp3/core/vpXmlParserCamera.h>

#include "config_error.h"
#include "temporary_folder.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

class CalibrationFile : public ::testing::Test {
 protected:
  std::string WriteOpenCv(const std::string& name, const std::vector<double>& lens) {
    const std::string path = (folder_.path() / name).string();
    cv::FileStorage file(path, cv::FileStorage::WRITE);
    file << "image_width" << 800 << "image_height" << 600;
    file << "camera_matrix"
         << (cv::Mat_<double>(3, 3) << 610.5, 0, 402.25, 0, 612.0, 298.5, 0, 0, 1);
    file << "distortion_coefficients" << cv::Mat(lens).reshape(1, 1);
    return path;
  }
  test::TemporaryFolder folder_;
};

void ExpectLens(const CameraModel& camera) {
  EXPECT_DOUBLE_EQ(camera.fx, 610.5);
  EXPECT_DOUBLE_EQ(camera.fy, 612.0);
  EXPECT_DOUBLE_EQ(camera.u0, 402.25);
  EXPECT_DOUBLE_EQ(camera.v0, 298.5);
  EXPECT_EQ(camera.width, 800);
  EXPECT_EQ(camera.height, 600);
  EXPECT_DOUBLE_EQ(camera.distortion.k1, -0.28);
  EXPECT_DOUBLE_EQ(camera.distortion.k2, 0.09);
  EXPECT_DOUBLE_EQ(camera.distortion.p1, 8e-4);
  EXPECT_DOUBLE_EQ(camera.distortion.p2, -5e-4);
  EXPECT_DOUBLE_EQ(camera.distortion.k3, -0.011);
}

TEST_F(CalibrationFile, IsReadAsOpenCvWritesIt) {
  for (const char* name : {"camera.yaml", "camera.xml", "camera.json"}) {
    SCOPED_TRACE(name);
    ExpectLens(ReadCalibration(WriteOpenCv(name, {-0.28, 0.09, 8e-4, -5e-4, -0.011})));
  }
}

TEST_F(CalibrationFile, IsReadAsRosWritesIt) {
  ExpectLens(ReadCalibration(folder_.Write("ros.yaml",
                                           "image_width: 800\n"
                                           "image_height: 600\n"
                                           "camera_name: wrist\n"
                                           "camera_matrix:\n"
                                           "  rows: 3\n"
                                           "  cols: 3\n"
                                           "  data: [610.5, 0, 402.25, 0, 612.0, 298.5, 0, 0, 1]\n"
                                           "distortion_model: plumb_bob\n"
                                           "distortion_coefficients:\n"
                                           "  rows: 1\n"
                                           "  cols: 5\n"
                                           "  data: [-0.28, 0.09, 0.0008, -0.0005, -0.011]\n")));
}

TEST_F(CalibrationFile, IsReadAsVispWritesIt) {
  const std::string path = (folder_.path() / "visp.xml").string();
  vpCameraParameters parameters;
  parameters.initPersProjWithDistortion(610.5, 612.0, 402.25, 298.5, -0.21, 0.2);
  vpXmlParserCamera parser;
  ASSERT_EQ(parser.save(parameters, path, "wrist", 800, 600), vpXmlParserCamera::SEQUENCE_OK);
  const CameraModel camera = ReadCalibration(path, 800, 600, "wrist");
  EXPECT_NEAR(camera.fx, 610.5, 1e-6);
  EXPECT_NEAR(camera.v0, 298.5, 1e-6);
  EXPECT_NEAR(camera.distortion.k1, -0.21, 1e-9);
  EXPECT_EQ(camera.width, 800);
  EXPECT_EQ(ReadCalibration(path).width, 800);
  EXPECT_THROW((void)ReadCalibration(path, 800, 600, "another"), ConfigError);
  EXPECT_THROW((void)ReadCalibration(path, 640, 480, "wrist"), ConfigError);
}

TEST_F(CalibrationFile, IsRefusedWithItsReason) {
  const auto error = [&](const std::string& text, int width = 0) {
    const std::string path = folder_.Write("bad.yaml", text);
    return test::ConfigErrorOf([&] { (void)ReadCalibration(path, width, 0); });
  };
  const std::string size = "image_width: 800\nimage_height: 600\n";
  const std::string matrix =
      "camera_matrix: {rows: 3, cols: 3, data: [610, 0, 402, 0, 612, 298, 0, 0, 1]}\n";
  EXPECT_NE(error(size).find("camera_matrix: missing"), std::string::npos);
  EXPECT_NE(error(size + "camera_matrix: {data: [610, 0, 402]}\n").find("must be 3x3"),
            std::string::npos);
  EXPECT_NE(error(size + "camera_matrix: {data: [0.1, 0, 402, 0, 612, 298, 0, 0, 1]}\n")
                .find("focal lengths"),
            std::string::npos);
  EXPECT_NE(error(matrix).find("image_width: missing"), std::string::npos);
  EXPECT_NE(error(size + matrix, 640).find("is 800 px, but the images in use have 640"),
            std::string::npos);
  EXPECT_NE(error(size + matrix + "distortion_coefficients: [0, 0, 0, 0, 0, 0.1, 0, 0]\n")
                .find("more than the five"),
            std::string::npos);
  EXPECT_NE(error(size + matrix + "distortion_model: equidistant\n").find("plumb_bob"),
            std::string::npos);
  EXPECT_NE(error("[not, a, mapping").find("bad.yaml"), std::string::npos);
  EXPECT_NE(test::ConfigErrorOf([] {
              (void)ReadCalibration("/no/such/file.yaml");
            }).find("cannot be read"),
            std::string::npos);
}

}  // namespace
}  // namespace vantage
