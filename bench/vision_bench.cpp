// From pixels to a joint command on one core: rendering, detection, the whole chain, beside ViSP's vpDot2,
// OpenCV and a bare memset of the buffers, in one run.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/imgproc.hpp>

#include "sim/render/arm_scene.h"
#include "sim/render/renderer.h"
#include "vantage/config/scenario.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"
#include "vantage/servo/servo.h"
#include "vantage/vision/marker_tracker.h"
#include "vision_detectors.h"
#include "vision_study.h"

namespace {

using namespace vantage;       // NOLINT: a program of its own
using namespace vantage::sim;  // NOLINT

constexpr int kStates = 64;          // Images of a slow motion, over and over.
constexpr double kImageRate = 60.0;  // [1/s].

struct Size {
  int width, height;
};

// ---- The cell ---------------------------------------------------------------------------------

// A PUMA 560 with four dots on its hand in the middle of the image, whatever the image's size.
Scenario MakeScenario(const Size& size) {
  const std::string w = std::to_string(size.width);
  const std::string h = std::to_string(size.height);
  const std::string f = std::to_string(1.25 * size.height);
  const std::string text =
      "robot: puma560\n"
      "markers:\n"
      "  - {id: 0, position: [0.05, 0.05, 0.02], normal: [0, 0, 1], radius: 0.02}\n"
      "  - {id: 1, position: [-0.05, 0.05, 0.02], normal: [0, 0, 1], radius: 0.02}\n"
      "  - {id: 2, position: [-0.05, -0.05, 0.02], normal: [0, 0, 1], radius: 0.02}\n"
      "  - {id: 3, position: [0.05, -0.05, 0.02], normal: [0, 0, 1], radius: 0.02}\n"
      "features: all_points\n"
      "camera: {width: " +
      w + ", height: " + h + ", fx: " + f +
      "}\n"
      "camera_rig:\n"
      "  kind: spherical\n"
      "  target: [0.35, -0.15, 0.95]\n"
      "  axes:\n"
      "    R:     {lower: 0.7, upper: 2.5, start: 2.0, max_speed: 0.35, max_acceleration: 1.0}\n"
      "    theta: {lower_deg: 5, upper_deg: 85, start_deg: 55, max_speed_deg_s: 25, "
      "max_acceleration_deg_s2: 80}\n"
      "    phi:   {lower_deg: -180, upper_deg: 180, start_deg: -15, max_speed_deg_s: 25, "
      "max_acceleration_deg_s2: 80}\n"
      "    roll:  {lower_deg: -180, upper_deg: 180, start_deg: 0, max_speed_deg_s: 40, "
      "max_acceleration_deg_s2: 120}\n"
      "goal: {joints_deg: [5, 55, -125, 0, 45, 5]}\n"
      "sim: {start_joints_deg: [0, 50, -130, 0, 40, 0]}\n";
  return ReadScenario({"bench_vision", "", text}, "bench");
}

// The arm from as many triangles as asked for, or a few more.
Scene MakeScene(const Scenario& scenario, int triangles) {
  Scene scene;
  ArmLook look;
  for (look.segments = 8;; look.segments += 2) {
    scene = MakeArmScene(scenario.task.view.arm, scenario.task.view.markers, {}, look);
    int count = 0;
    for (const Body& body : scene.bodies) count += body.mesh.triangles();
    if (count >= triangles) return scene;
  }
}

struct Moment {
  JointVector q;
  SceneState scene;
};

struct Cell {
  Scenario scenario;
  Renderer renderer;
  Eigen::Isometry3d X_WC;
  std::vector<Moment> moments;
  std::vector<std::vector<MarkerPrediction>> predictions;  // Of each moment.
  std::vector<GreyImage> images;                           // Of each moment; made when asked for.

  const GreyImage& Image(int i) {
    if (images.empty()) {
      images.resize(kStates);
      for (int k = 0; k < kStates; ++k) {
        renderer.RenderGrey(X_WC, moments[k].scene, &images[k]);
      }
    }
    return images[i];
  }
};

std::vector<MarkerPrediction> Predict(const Scenario& scenario, const Eigen::Isometry3d& X_WC,
                                      const Eigen::Isometry3d& X_WE) {
  std::vector<MarkerPrediction> predictions;
  const Eigen::Isometry3d X_CE = X_WC.inverse() * X_WE;
  for (const Marker& marker : scenario.task.view.markers) {
    predictions.push_back(PredictMarker(scenario.task.view.camera, X_CE, marker, 0));
  }
  return predictions;
}

std::unique_ptr<Cell> MakeCell(const Size& size, int triangles) {
  Scenario scenario = MakeScenario(size);
  Renderer renderer(MakeGlContext(), scenario.task.view.camera, MakeScene(scenario, triangles));
  const Eigen::Isometry3d X_WC = RigPose(scenario.rig, scenario.q_c_start);
  auto cell =
      std::make_unique<Cell>(Cell{std::move(scenario), std::move(renderer), X_WC, {}, {}, {}});
  const ArmModel& arm = cell->scenario.task.view.arm;
  for (int i = 0; i < kStates; ++i) {
    // There and back, without a jump.
    const double s = 0.05 * std::sin(2.0 * kPi * i / kStates);
    Moment moment;
    moment.q = cell->scenario.sim.q_start + s * JointVector::Ones(arm.size());
    moment.scene = {ComputeLinkPoses(arm, moment.q), EndEffectorPose(arm, moment.q)};
    cell->predictions.push_back(Predict(cell->scenario, X_WC, moment.scene.X_WE));
    cell->moments.push_back(moment);
  }
  return cell;
}

// Contexts cost time to make: one cell for all benchmarks of a kind. Owned by main(), as GL libraries do
// not outlive it.
class Cells {
 public:
  Cell& Of(const Size& size, int triangles) {
    std::unique_ptr<Cell>& cell = cells_[{size.width, size.height, triangles}];
    if (!cell) cell = MakeCell(size, triangles);
    return *cell;
  }

 private:
  std::map<std::tuple<int, int, int>, std::unique_ptr<Cell>> cells_;
};

// ---- The work ---------------------------------------------------------------------------------

void Memset(benchmark::State& state, const Size& size) {
  std::vector<std::uint8_t> colour(static_cast<std::size_t>(size.width) * size.height);
  std::vector<std::uint32_t> depth(colour.size());
  for (auto _ : state) {
    std::memset(colour.data(), 119, colour.size());
    std::memset(depth.data(), 255, 4 * depth.size());
    benchmark::DoNotOptimize(colour.data());
    benchmark::DoNotOptimize(depth.data());
    benchmark::ClobberMemory();
  }
}

void Render(benchmark::State& state, Cells* cells, const Size& size, int triangles,
            bool scissored) {
  Cell& cell = cells->Of(size, triangles);
  const DetectorOptions options;
  std::vector<std::vector<PixelWindow>> windows;
  for (const auto& predictions : cell.predictions) {
    windows.emplace_back();
    for (const MarkerPrediction& p : predictions)
      windows.back().push_back(SearchWindow(p, options));
  }
  GreyImage image;
  int i = 0;
  for (auto _ : state) {
    const SceneState& scene = cell.moments[i].scene;
    if (scissored) {
      cell.renderer.RenderGrey(cell.X_WC, scene, windows[i], &image);
    } else {
      cell.renderer.RenderGrey(cell.X_WC, scene, &image);
    }
    i = (i + 1) % kStates;
  }
}

// Each must have found all dots, or its time says nothing.
bool AllFound(const MarkerDetections& detections) {
  return std::all_of(detections.begin(), detections.end(),
                     [](const MarkerDetection& d) { return d.valid(); });
}

void Detect(benchmark::State& state, Cells* cells, const Size& size, bench::Detector detector) {
  Cell& cell = cells->Of(size, 5000);
  const CameraModel& camera = cell.scenario.task.view.camera;
  MarkerDetections detections;
  cell.Image(0);
  double error = 0.0;
  for (int i = 0; i < kStates; ++i) {
    detector(View(cell.Image(i)), camera, cell.predictions[i], &detections);
    if (!AllFound(detections)) state.SkipWithError("lost a dot");
    for (std::size_t k = 0; k < detections.size(); ++k) {
      error += (detections[k].pixel - cell.predictions[i][k].image.centre).norm();
    }
  }
  int i = 0;
  for (auto _ : state) {
    detector(View(cell.images[i]), camera, cell.predictions[i], &detections);
    benchmark::DoNotOptimize(detections.data());
    i = (i + 1) % kStates;
  }
  state.counters["error_px"] = error / (kStates * static_cast<double>(detections.size()));
}

void Acquire(benchmark::State& state, Cells* cells, const Size& size) {
  Cell& cell = cells->Of(size, 5000);
  const CameraModel& camera = cell.scenario.task.view.camera;
  MarkerDetections detections;
  int i = 0;
  cell.Image(0);
  for (auto _ : state) {
    detections = AcquireMarkers(View(cell.images[i]), camera, cell.predictions[i], {}, {});
    if (!AllFound(detections)) state.SkipWithError("lost a dot");
    i = (i + 1) % kStates;
  }
}

// OpenCV's contours on the whole image: what an acquisition costs by the usual way, names not included.
void AcquireOpenCv(benchmark::State& state, Cells* cells, const Size& size) {
  Cell& cell = cells->Of(size, 5000);
  int i = 0;
  cell.Image(0);
  cv::Mat binary;
  std::vector<std::vector<cv::Point>> contours;
  for (auto _ : state) {
    const cv::Mat whole(size.height, size.width, CV_8U, cell.images[i].pixels.data());
    cv::threshold(whole, binary, 0, 255, cv::THRESH_BINARY_INV | cv::THRESH_OTSU);
    cv::findContours(binary, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    double sum = 0.0;
    for (const auto& contour : contours) sum += cv::moments(contour).m00;
    benchmark::DoNotOptimize(sum);
    i = (i + 1) % kStates;
  }
}

// All of it: prediction by the model, image, tracker, servo with its measures and the bounded law.
void PixelsToCommand(benchmark::State& state, Cells* cells, const Size& size, int triangles,
                     bool scissored) {
  Cell& cell = cells->Of(size, triangles);
  const Scenario& scenario = cell.scenario;
  Servo servo(scenario.task, scenario.servo, scenario.active.trigger);
  MarkerTracker tracker(scenario.task.view.camera, {});
  GreyImage image;
  ImageFeatures features;
  features.X_WC = cell.X_WC;
  Time now{std::chrono::seconds(1)};
  int i = 0;
  const auto step = [&] {
    const Moment& moment = cell.moments[i];
    i = (i + 1) % kStates;
    now += FromSeconds(1.0 / kImageRate);
    const auto predictions =
        Predict(scenario, cell.X_WC, EndEffectorPose(scenario.task.view.arm, moment.q));
    const MarkerTracker::SearchPlan& plan = tracker.Plan(predictions, now);
    if (scissored && !plan.whole_image) {
      cell.renderer.RenderGrey(cell.X_WC, moment.scene, plan.windows, &image);
    } else {
      cell.renderer.RenderGrey(cell.X_WC, moment.scene, &image);
    }
    tracker.Track(View(image), predictions, now);
    tracker.Publish(&features);
    features.stamp = features.exposure = now;
    servo.Accept(JointState{now, moment.q, JointVector::Zero(moment.q.size())}, now);
    servo.Accept(CameraPose{now, cell.X_WC}, now);
    servo.Accept(features, now);
    return servo.Step(now).status.state;
  };
  for (int k = 0; k < 10; ++k) step();
  for (auto _ : state) {
    if (step() == ServoState::kHolding) state.SkipWithError("the servo holds");
  }
}

// ---- The study ---------------------------------------------------------------------------------

// Its counters; the time is that of one image's detection.
class Study {
 public:
  void Report(benchmark::State& state, const bench::Condition& condition, std::size_t detector) {
    for (auto _ : state) {
      std::vector<bench::StudyResult>& results = results_[condition.name];
      if (results.empty()) results = bench::RunStudy(condition);
      state.SetIterationTime(1e-6 * results[detector].microseconds);
    }
    const bench::StudyResult& result = results_[condition.name][detector];
    state.counters["mean_px"] = result.mean_error;
    state.counters["max_px"] = result.max_error;
    state.counters["found"] = static_cast<double>(result.found) / std::max(1, result.whole);
    state.counters["damaged"] = result.damaged;
    state.counters["bad_accepted"] = result.bad_accepted;
  }

  void PrintTable() const {
    if (results_.empty()) return;
    std::printf(
        "\nAgainst the truth: 120 images of four dots, 640x480\n%-9s %-7s %9s %9s %7s %8s %8s "
        "%7s\n",
        "images", "by", "mean px", "max px", "found", "damaged", "accepted", "us");
    for (const bench::Condition& condition : bench::Conditions()) {
      const auto results = results_.find(condition.name);
      if (results == results_.end()) continue;
      for (std::size_t d = 0; d < results->second.size(); ++d) {
        const bench::StudyResult& r = results->second[d];
        std::printf("%-9s %-7s %9.4f %9.4f %5.1f %% %8d %8d %7.1f\n", condition.name.c_str(),
                    bench::kDetectors[d].name, r.mean_error, r.max_error,
                    100.0 * r.found / std::max(1, r.whole), r.damaged, r.bad_accepted,
                    r.microseconds);
      }
    }
    std::printf(
        "damaged: discs cut by the border or hidden by more than 2 %%; accepted: those of them "
        "that were\n"
        "taken for good, and whole ones more than 0.5 px off\n");
  }

 private:
  std::map<std::string, std::vector<bench::StudyResult>> results_;
};

// ---- Registration ------------------------------------------------------------------------------

void Register(Cells* cells, Study* study) {
  using benchmark::RegisterBenchmark;
  using benchmark::State;
  for (const Size& size : {Size{320, 240}, Size{640, 480}, Size{1280, 720}}) {
    const std::string at = "/" + std::to_string(size.width) + "x" + std::to_string(size.height);
    RegisterBenchmark(("memset" + at).c_str(), [=](State& s) { Memset(s, size); });
    for (const int triangles : {5000, 50000}) {
      for (const bool scissored : {false, true}) {
        const std::string name = std::string(scissored ? "/scissored" : "/full") + at + "/" +
                                 std::to_string(triangles / 1000) + "k";
        RegisterBenchmark(("render" + name).c_str(),
                          [=](State& s) { Render(s, cells, size, triangles, scissored); });
        RegisterBenchmark(("pixels_to_command" + name).c_str(),
                          [=](State& s) { PixelsToCommand(s, cells, size, triangles, scissored); });
      }
    }
    for (const bench::NamedDetector& detector : bench::kDetectors) {
      RegisterBenchmark((std::string("detect/") + detector.name + at).c_str(),
                        [=](State& s) { Detect(s, cells, size, detector.detect); });
    }
    RegisterBenchmark(("acquire/ours" + at).c_str(), [=](State& s) { Acquire(s, cells, size); });
    RegisterBenchmark(("acquire/opencv" + at).c_str(),
                      [=](State& s) { AcquireOpenCv(s, cells, size); });
  }
  for (const bench::Condition& condition : bench::Conditions()) {
    for (std::size_t d = 0; d < std::size(bench::kDetectors); ++d) {
      const std::string name = "study/" + condition.name + "/" + bench::kDetectors[d].name;
      RegisterBenchmark(name.c_str(), [=](State& s) { study->Report(s, condition, d); })
          ->UseManualTime()
          ->Iterations(1);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  Cells cells;
  Study study;
  Register(&cells, &study);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  study.PrintTable();
  return 0;
}
