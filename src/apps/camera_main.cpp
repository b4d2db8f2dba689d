// vantage-camera SCENARIO --source SOURCE: a real camera, or a recording, in the place of the simulator's
// camera: finds the scenario's markers and publishes IMAGE_FEATURES and CAMERA_IMAGE.

#include <algorithm>
#include <atomic>
#include <future>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "app.h"
#include "image_message.h"
#include "vantage/config/scenario.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"
#include "vantage/math/spatial.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/transport.h"
#include "vantage/robot/kinematics.h"
#include "vantage/runtime/latest_value.h"
#include "vantage/runtime/periodic_loop.h"
#include "vantage/runtime/signal_stop.h"
#include "vantage/servo/history.h"
#include "vantage/vision/calibration_file.h"
#include "vantage/vision/camera_source.h"
#include "vantage/vision/marker_tracker.h"

namespace vantage {
namespace {

constexpr double kUsualRate = 30.0;  // Of files that do not say [1/s].
constexpr double kSlow = 0.8;        // Of the expected rate.
constexpr double kRateWindow = 2.0;  // [s].
constexpr double kStall = 1.0;       // An image that comes later than this is missed [s].
constexpr Duration kRetry = std::chrono::milliseconds(500);
constexpr Duration kLook = std::chrono::milliseconds(50);  // How soon a stop is seen.

struct Arguments {
  std::string scenario = kDefaultScenario;
  std::string source;
  std::string calibration;
  std::string calibration_name;
  std::string prefix;
  VideoOptions video;
  double image_rate = 10.0;
  double give_up = 10.0;
  bool fast = false;
};

void Say(const std::string& text) {
  std::cerr << "vantage-camera: " << text << '\n';
}

std::string Rounded(double value) {
  return Format("%.1f", value);
}

/// Joints and camera pose over time, as they arrive; what the scenario starts with until then.
class Surroundings {
 public:
  Surroundings(const Scenario& scenario, LcmLink* link)
      : q_start_(scenario.sim.q_start), X_start_(RigPose(scenario.rig, scenario.q_c_start)) {
    link->Subscribe<JointState>(kJointStateChannel, [this](const JointState& v) {
      const std::lock_guard lock(mutex_);
      if (v.q.size() == q_start_.size()) joints_.Push(v.stamp, v.q);
    });
    link->Subscribe<CameraPose>(kCameraPoseChannel, [this](const CameraPose& v) {
      const std::lock_guard lock(mutex_);
      poses_.Push(v.stamp, v.X_WC);
    });
  }

  [[nodiscard]] JointVector JointsAt(Time time) const {
    const std::lock_guard lock(mutex_);
    const auto between = [](const JointVector& a, const JointVector& b, double s) -> JointVector {
      return a + s * (b - a);
    };
    return joints_.At(time, between).value_or(q_start_);
  }
  [[nodiscard]] Eigen::Isometry3d PoseAt(Time time) const {
    const std::lock_guard lock(mutex_);
    return poses_.At(time, PoseBetween).value_or(X_start_);
  }
  [[nodiscard]] bool has_joints() const {
    const std::lock_guard lock(mutex_);
    return !joints_.empty();
  }

 private:
  mutable std::mutex mutex_;
  JointVector q_start_;
  Eigen::Isometry3d X_start_;
  History<JointVector, 512> joints_;
  History<Eigen::Isometry3d, 512> poses_;
};

/// Pictures for people, in a thread of their own so that JPEG does not hold up the features.
class PicturePublisher {
 public:
  PicturePublisher(double rate, LcmLink* link) : rate_(rate), link_(link) {
    if (rate_ > 0.0) thread_ = std::thread([this] { Loop(); });
  }
  ~PicturePublisher() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  PicturePublisher(const PicturePublisher&) = delete;
  PicturePublisher& operator=(const PicturePublisher&) = delete;

  void Show(const GreyImage& image, Time exposure) {
    if (rate_ > 0.0) newest_.Publish({image, exposure});
  }

 private:
  struct Picture {
    GreyImage image;
    Time exposure{};
  };
  void Loop() {
    Picture picture;
    RunPeriodic(FromSeconds(1.0 / rate_), stop_, [&] {
      if (!newest_.Take(&picture)) return;
      const cv::Mat grey(picture.image.height, picture.image.width, CV_8U,
                         picture.image.pixels.data());
      link_->Publish(kCameraImageChannel, JpegMessage(grey, picture.exposure));
    });
  }

  double rate_;
  LcmLink* link_;
  LatestValue<Picture> newest_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Says once when images come more slowly than expected, and once when they do no longer.
class RateWatch {
 public:
  RateWatch(std::string source, double expected)
      : source_(std::move(source)), expected_(expected) {}

  void Count(Time now) {
    if (count_ == 0) start_ = now;
    const double elapsed = ToSeconds(now - start_);
    if (elapsed < kRateWindow) {
      ++count_;
      return;
    }
    const double rate = count_ / elapsed;
    count_ = 0;
    if (expected_ <= 0.0) return;
    const bool slow = rate < kSlow * expected_;
    if (slow != slow_) {
      Say(source_ + (slow ? " is slow: " : " is at its rate again: ") + Rounded(rate) +
          " images/s of " + Rounded(expected_));
    }
    slow_ = slow;
  }
  void Reset() noexcept { count_ = 0; }

 private:
  std::string source_;
  double expected_;
  Time start_{};
  int count_{0};
  bool slow_{false};
};

/// Calls f on a thread of its own. Drivers may hang, and nothing frees a thread that does: it is left behind,
/// so f shares what it uses.
template <typename F>
[[nodiscard]] auto CallBeside(F f) {
  std::packaged_task<std::invoke_result_t<F>()> task(std::move(f));
  auto result = task.get_future();
  std::thread(std::move(task)).detach();
  return result;
}

/// One attempt to take an image, and what came of it.
struct Shot {
  GrabStatus status{GrabStatus::kNoImage};
  GreyImage image;
  Time exposure{};
};

class CameraProgram {
 public:
  CameraProgram(const Arguments& arguments, Scenario scenario)
      : arguments_(arguments),
        scenario_(std::move(scenario)),
        goal_markers_(BelievedGoalMarkers(scenario_)),
        tracker_(camera(), scenario_.vision),
        transport_(JoinTransport()),
        link_({transport_.url, arguments.prefix}),
        surroundings_(scenario_, &link_) {}

  int Run() {
    if (!transport_.explanation.empty()) std::cerr << transport_.explanation << '\n';
    asked_ = Clock::now();
    auto opened = Await(CallBeside([source = arguments_.source, video = arguments_.video] {
      return OpenVideo(source, video);
    }));
    if (!opened) return ExitCode();
    source_ = *std::move(opened);
    link_.Start();
    Say(source_->description() + ", " + scenario_.name + ", on " + transport_.url);
    PicturePublisher pictures(arguments_.image_rate, &link_);
    const double rate = ExpectedRate();
    if (rate > 0.0) period_ = 1.0 / rate;
    RateWatch watch(source_->description(), arguments_.fast ? 0.0 : rate);
    Time next = Clock::now();
    while (!stop_.stopped()) {
      if (source_->is_file() && !arguments_.fast) {
        SleepUntil(next);
        next += FromSeconds(period_);
      }
      const GrabStatus status = NextImage();
      if (status == GrabStatus::kEndOfFile) {
        Say("end of " + source_->description() + " after " + Counts());
        return kExitOk;
      }
      if (status == GrabStatus::kNoImage) break;
      if (missed_) watch.Reset();
      missed_ = false;
      CheckSize();
      Publish(shot_.exposure);
      pictures.Show(shot_.image, shot_.exposure);
      watch.Count(Clock::now());
    }
    if (stop_.stopped()) Say("stopped after " + Counts());
    return ExitCode();
  }

 private:
  [[nodiscard]] const CameraModel& camera() const { return scenario_.task.view.camera; }

  [[nodiscard]] double ExpectedRate() const {
    if (arguments_.video.rate > 0.0) return arguments_.video.rate;
    if (source_->nominal_rate() > 0.0) return source_->nominal_rate();
    return source_->is_file() ? kUsualRate : 0.0;
  }

  [[nodiscard]] std::string Counts() const {
    return std::to_string(images_) + " images, " + std::to_string(complete_) +
           " of them with every marker that could be seen";
  }

  void CheckSize() const {
    if (shot_.image.width == camera().width && shot_.image.height == camera().height) return;
    throw ConfigError("", "camera",
                      source_->description() + " gives images of " +
                          std::to_string(shot_.image.width) + "x" +
                          std::to_string(shot_.image.height) + " px, the scenario's camera has " +
                          std::to_string(camera().width) + "x" + std::to_string(camera().height) +
                          ": ask the device for it (--width, --height) or give its calibration");
  }

  void Publish(Time exposure) {
    const ViewModel& view = scenario_.task.view;
    const Eigen::Isometry3d X_WC = surroundings_.PoseAt(exposure);
    const Eigen::Isometry3d X_CW = X_WC.inverse();
    const Eigen::Isometry3d X_CE =
        X_CW * EndEffectorPose(view.arm, surroundings_.JointsAt(exposure));
    PredictMarkers(view.camera, X_CW, X_CE, view.markers, goal_markers_, &predictions_);
    bool complete = true;
    for (const MarkerDetection& d : tracker_.Track(View(shot_.image), predictions_, exposure)) {
      complete = complete && (d.valid() || d.fault == MarkerFault::kNotExpected);
    }
    tracker_.Publish(&features_);
    features_.exposure = exposure;
    features_.X_WC = X_WC;
    features_.stamp = Clock::now();
    link_.Publish(kImageFeaturesChannel, features_);
    ++images_;
    complete_ += complete ? 1 : 0;
    if (images_ == 100 && !surroundings_.has_joints()) {
      Say("no JOINT_STATE so far: markers are sought round the scenario's start");
    }
  }

  [[nodiscard]] int ExitCode() const { return stop_.stopped() ? kExitOk : kExitFailure; }

  // Waits for the next image, and for a device that is gone until it is back. kNoImage when the user or
  // --give-up ended that.
  GrabStatus NextImage() {
    asked_ = Clock::now();
    for (;;) {
      auto shot = Await(CallBeside([source = source_, shot = std::move(shot_)]() mutable {
        shot.status = source->Grab(&shot.image, &shot.exposure);
        return std::move(shot);
      }));
      if (!shot) return GrabStatus::kNoImage;
      shot_ = *std::move(shot);
      if (shot_.status != GrabStatus::kNoImage) break;
      Miss("unplugged?");
      if (!WaitForDevice()) return GrabStatus::kNoImage;
    }
    if (missed_ && shot_.status == GrabStatus::kImage) {
      Say(source_->description() + " is back after " + Rounded(Waited()) + " s");
    }
    return shot_.status;
  }

  // Opens the device again and again.
  bool WaitForDevice() {
    while (!stop_.WaitFor(kRetry)) {
      const auto open = Await(CallBeside([source = source_] { return source->Reopen(); }));
      if (!open) return false;
      if (*open) return true;
      if (GivesUp()) return false;
    }
    return false;
  }

  // The result of a call of the source; nullopt when the user or --give-up ended the wait for it.
  template <typename R>
  std::optional<R> Await(std::future<R> result) {
    while (result.wait_for(kLook) != std::future_status::ready) {
      if (stop_.stopped() || GivesUp()) return std::nullopt;
      if (Waited() > period_ + kStall) Miss("stalled?");
    }
    return result.get();
  }

  [[nodiscard]] double Patience() const { return std::max(kStall, arguments_.give_up); }
  [[nodiscard]] double Waited() const { return ToSeconds(Clock::now() - asked_); }

  [[nodiscard]] std::string SourceName() const {
    return source_ ? source_->description() : arguments_.source;
  }

  // Says so once for each image that is missed.
  void Miss(const char* guess) {
    if (missed_) return;
    missed_ = true;
    Say("no image from " + SourceName() + " after " + Counts() + ": " + guess + " Waiting for " +
        Rounded(Patience()) + " s");
  }

  [[nodiscard]] bool GivesUp() const {
    if (Waited() < period_ + Patience()) return false;
    Say(SourceName() + " is gone: giving up after " + Counts());
    return true;
  }

  Arguments arguments_;
  Scenario scenario_;
  std::vector<Marker> goal_markers_;
  SignalStop stop_;
  std::shared_ptr<CameraSource> source_;  // Null until it is open.
  MarkerTracker tracker_;
  Transport transport_;
  LcmLink link_;
  Surroundings surroundings_;
  Shot shot_;
  double period_{0.0};  // Between images, where it is known [s].
  Time asked_{};        // Since when the next image is waited for.
  bool missed_{false};  // It should have come by now.
  std::vector<MarkerPrediction> predictions_;
  ImageFeatures features_;
  std::int64_t images_{0};
  std::int64_t complete_{0};
};

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Finds a scenario's markers in the images of a real camera or a recording, and publishes "
      "IMAGE_FEATURES and CAMERA_IMAGE. Takes JOINT_STATE and CAMERA_POSE to know where to look.",
      "vantage-camera");
  app.add_option("scenario", arguments.scenario, "Built-in scenario or a YAML file")
      ->capture_default_str();
  app.add_option("--source", arguments.source,
                 "Device (0, /dev/video0), video file, image sequence (frames/%05d.png), stream "
                 "(rtsp://...) or GStreamer pipeline ('... ! appsink')")
      ->required();
  app.add_option("--calibration", arguments.calibration,
                 "Calibration file instead of the scenario's camera: OpenCV's YAML or XML, ROS's "
                 "YAML, ViSP's XML");
  app.add_option("--calibration-name", arguments.calibration_name,
                 "Which camera of a ViSP file that holds several");
  app.add_option("--prefix", arguments.prefix, "Before every channel name");
  app.add_option("--width", arguments.video.width, "Image width asked of a device [px]")
      ->check(CLI::Range(16, 8192));
  app.add_option("--height", arguments.video.height, "Image height asked of a device [px]")
      ->check(CLI::Range(16, 8192));
  app.add_option("--rate", arguments.video.rate,
                 "Images per second: asked of a device, or at which a file is played")
      ->check(CLI::Range(0.1, 10000.0));
  app.add_flag("--fast", arguments.fast, "Plays a file as fast as it can be read");
  app.add_option("--delay", arguments.video.delay,
                 "Images arrive this long after their exposure [s]")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--image-rate", arguments.image_rate, "CAMERA_IMAGE messages [1/s]; 0: none")
      ->check(CLI::Range(0.0, 30.0))
      ->capture_default_str();
  app.add_option(
         "--give-up", arguments.give_up,
         "A device that is gone, or gives no images, is waited for this long, but at least 1 s [s]")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  return vantage::RunApp(&app, argc, argv, "", [&] {
    vantage::Scenario scenario = vantage::LoadScenario(arguments.scenario);
    if (!arguments.calibration.empty()) {
      scenario.task.view.camera =
          vantage::ReadCalibration(arguments.calibration, arguments.video.width,
                                   arguments.video.height, arguments.calibration_name);
    }
    return vantage::CameraProgram(arguments, std::move(scenario)).Run();
  });
}
