#include "vantage/report/run_record.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "temporary_folder.h"
#include "vantage/math/error.h"
#include "vantage/report/gnuplot.h"

namespace vantage {
namespace {

class RunRecord : public ::testing::Test {
 protected:
  [[nodiscard]] std::string File(const char* name) const {
    return (folder_.path() / name).string();
  }

  static std::vector<RunSample> Samples() {
    std::vector<RunSample> samples;
    for (int i = 0; i < 200; ++i) {
      RunSample s;
      s.t = 0.02 * i;
      s.state = ServoState::kServoing;
      s.error_px = 80.0 * std::exp(-s.t);
      s.w_v = 1e9;
      s.w_r = 0.05;
      s.w_c = 1e8 * (1 + s.t);
      s.trigger_value = 60.0 + 40.0 * s.t;
      s.threshold = 120.0;
      s.mm_per_px = 3.0;
      s.camera_moving = i > 50 && i < 90;
      s.true_error_mm = 100.0 * std::exp(-s.t);
      samples.push_back(s);
    }
    return samples;
  }

  test::TemporaryFolder folder_;
};

TEST_F(RunRecord, SamplesHaveOneLineEachUnderAHeader) {
  WriteSamples(Samples(), File("samples.csv"));
  std::ifstream file(File("samples.csv"));
  std::string header;
  std::getline(file, header);
  EXPECT_NE(header.find("error [px]"), std::string::npos);
  int lines = 0;
  for (std::string line; std::getline(file, line);) {
    ++lines;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
  EXPECT_EQ(lines, 200);
}

TEST_F(RunRecord, SummaryIsValidJsonEvenWithInfinities) {
  RunSummary summary;
  summary.scenario = "a \"quoted\" name";
  summary.observability.mm_per_px = std::numeric_limits<double>::infinity();
  summary.true_error_mm = 1.5;
  WriteSummary(summary, File("summary.json"));
  const auto json = nlohmann::json::parse(std::ifstream(File("summary.json")));
  EXPECT_EQ(json["scenario"], summary.scenario);
  EXPECT_TRUE(json["final_mm_per_px"].is_null());
  EXPECT_EQ(json["final_true_error_mm"], 1.5);
  EXPECT_TRUE(json["time_to_converge_s"].is_null());
}

// The picture shows the blue band of the camera's move and curves in it.
TEST_F(RunRecord, PictureShowsCurvesAndTheCamerasMove) {
  WriteSamples(Samples(), File("samples.csv"));
  RunSummary summary;
  summary.scenario = "test";
  summary.camera = "active";
  summary.end = "converged";
  PlotRun(summary, Samples(), folder_.path().string());
  const cv::Mat picture = cv::imread(File("run.png"));
  ASSERT_EQ(picture.cols, 1200);
  ASSERT_EQ(picture.rows, 1280);
  cv::Mat band;
  cv::inRange(picture, cv::Scalar(0xf7, 0xe9, 0xdc), cv::Scalar(0xf7, 0xe9, 0xdc), band);
  EXPECT_GT(cv::countNonZero(band), 10000);
  cv::Mat curve;
  cv::inRange(picture, cv::Scalar(0x9c, 0x4e, 0x1f), cv::Scalar(0x9c, 0x4e, 0x1f), curve);
  EXPECT_GT(cv::countNonZero(curve), 500);
}

// Names come from files and logs: what gnuplot would take for a subscript, or hand to a shell, stands in the picture
// letter by letter, and a folder may be called anything.
TEST_F(RunRecord, PictureIsDrawnWhateverTheNamesAre) {
  const std::filesystem::path folder = folder_.path() / "it's \"mine\"";
  std::filesystem::create_directory(folder);
  WriteSamples(Samples(), (folder / "samples.csv").string());
  RunSummary summary;
  summary.scenario = "my_\"own\"_{cell} `touch made` \\`touch made\\`";
  summary.camera = "active";
  summary.end = "vantage-sim ended with exit code 3";
  PlotRun(summary, Samples(), folder.string());
  EXPECT_EQ(cv::imread((folder / "run.png").string()).rows, 1280);
  EXPECT_FALSE(std::filesystem::exists(folder / "made"));
}

TEST(GnuplotString, HoldsTheTextAndNothingElse) {
  EXPECT_EQ(GnuplotString("a b"), "\"a b\"");
  EXPECT_EQ(GnuplotString("`x` \"y\" \\ $z\n"), "\"\\`x\\` \\\"y\\\" \\\\ \\$z\\n\"");
  EXPECT_EQ(GnuplotLiteral("a_b{c}\n"), "a\\_b\\{c\\} ");
}

// A view in which one pixel hides any motion, all the time: the other curves are drawn all the same.
TEST_F(RunRecord, PictureIsDrawnWithoutAFiniteValue) {
  std::vector<RunSample> samples = Samples();
  for (RunSample& sample : samples) {
    sample.mm_per_px = std::numeric_limits<double>::infinity();
    sample.w_v = sample.w_r = sample.w_c = sample.trigger_value = 0.0;
    sample.true_error_mm.reset();
  }
  WriteSamples(samples, File("samples.csv"));
  PlotRun({}, samples, folder_.path().string());
  const cv::Mat picture = cv::imread(File("run.png"));
  ASSERT_EQ(picture.rows, 1280);
  cv::Mat curve;
  cv::inRange(picture, cv::Scalar(0x9c, 0x4e, 0x1f), cv::Scalar(0x9c, 0x4e, 0x1f), curve);
  EXPECT_GT(cv::countNonZero(curve), 500);
}

TEST_F(RunRecord, UnwritableFileIsAnErrorThatNamesIt) {
  try {
    WriteSamples(Samples(), File("no/such/folder.csv"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("no/such/folder.csv"), std::string::npos);
  }
}

TEST_F(RunRecord, BrokenScriptIsAnErrorThatSaysWhatGnuplotSaid) {
  std::ofstream(File("bad.gp")) << "plat 'nothing'\n";
  try {
    RunGnuplot(File("bad.gp"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("plat"), std::string::npos) << e.what();
  }
}

TEST_F(RunRecord, MissingGnuplotIsAnErrorThatSaysHowToInstallIt) {
  std::ofstream(File("good.gp")) << "print 1\n";
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder_.path().c_str(), 1);
  std::string message;
  try {
    RunGnuplot(File("good.gp"));
  } catch (const Error& e) {
    message = e.what();
  }
  setenv("PATH", path.c_str(), 1);
  EXPECT_NE(message.find("apt-get install gnuplot-nox"), std::string::npos) << message;
  EXPECT_FALSE(std::filesystem::exists(File("good.gp.log")));
}

}  // namespace
}  // namespace vantage
