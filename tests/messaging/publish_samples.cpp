// publish_samples SECONDS [URL]
//
// Publishes a value of every message type, slowly changing, at 50 Hz (images at 10 Hz): something for
// lcm-spy, lcm-logger and the like to show. Without URL it runs a hub and prints its ready line.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>

#include "samples.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/messaging/transport.h"

namespace vantage {
namespace {

CameraImage MovingPicture(double t) {
  CameraImage image;
  image.width = 160;
  image.height = 120;
  image.row_stride = 160;
  image.data.resize(160 * 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const double distance = std::hypot(x - 80 - 40 * std::sin(t), y - 60 - 30 * std::cos(t));
      image.data[y * 160 + x] = static_cast<std::uint8_t>(distance < 15 ? 20 : 200);
    }
  }
  return image;
}

void PublishAll(double t, bool with_image, LcmLink* link) {
  JointState state = test::SampleJointState();
  state.stamp = Clock::now();
  for (int i = 0; i < state.q.size(); ++i) state.q[i] = std::sin(t + i);
  link->Publish(kJointStateChannel, state);
  JointCommand command = test::SampleJointCommand();
  command.stamp = state.stamp;
  link->Publish(kJointCommandChannel, command);
  CameraPose pose = test::SampleCameraPose();
  pose.stamp = state.stamp;
  pose.X_WC.translation().x() = std::cos(t);
  link->Publish(kCameraPoseChannel, pose);
  link->Publish(kCameraPoseCommandChannel, pose);
  ImageFeatures features = test::SampleImageFeatures();
  features.stamp = state.stamp;
  features.exposure = state.stamp - std::chrono::milliseconds(20);
  features.markers[0].pixel.x() = 320 + 100 * std::sin(t);
  link->Publish(kImageFeaturesChannel, features);
  ObservabilityReport report = test::SampleObservability();
  report.stamp = state.stamp;
  report.trigger_value = 150 + 60 * std::sin(t);
  report.triggered = report.trigger_value < report.threshold;
  link->Publish(kObservabilityChannel, report);
  ServoStatus status = test::SampleServoStatus();
  status.stamp = state.stamp;
  status.error_px = 10 * std::exp(-0.2 * t);
  link->Publish(kServoStatusChannel, status);
  GroundTruth truth = test::SampleGroundTruth();
  truth.stamp = state.stamp;
  link->Publish(kSimTruthChannel, truth);
  if (with_image) {
    CameraImage image = MovingPicture(t);
    image.stamp = state.stamp;
    link->Publish(kCameraImageChannel, image);
  }
}

int Run(double seconds, const char* url) {
  std::unique_ptr<TcpHub> hub;
  Transport transport;
  if (url != nullptr) {
    transport.url = url;
  } else {
    hub = std::make_unique<TcpHub>();
    transport.url = hub->url();
  }
  LcmLink link({transport.url, ""});
  link.Start();
  std::printf("%s\n", transport.ReadyLine().c_str());
  std::fflush(stdout);
  const Time start = Clock::now();
  for (int i = 0; Clock::now() - start < FromSeconds(seconds); ++i) {
    PublishAll(0.02 * i, i % 5 == 0, &link);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return link.stats().unsent == 0 ? 0 : 1;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: publish_samples SECONDS [URL]\n");
    return 2;
  }
  return vantage::Run(std::atof(argv[1]), argc == 3 ? argv[2] : nullptr);
}
