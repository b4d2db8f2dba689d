#include "run_lockstep.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "vantage/math/error.h"

namespace vantage {
namespace {

void WritePicture(sim::Renderer* renderer, const sim::WorldView& view, const std::string& path) {
  ColourImage image;
  renderer->RenderColour(view.X_WC, view.scene, &image);
  const cv::Mat rgb(image.height, image.width, CV_8UC3, image.pixels.data());
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  if (!cv::imwrite(path, bgr)) throw WriteError(path);
}

}  // namespace

sim::LockstepRun RunInLockstep(const Scenario& scenario, const RunFolder& folder,
                               RunConsole* console, sim::RunUntil until) {
  sim::Renderer renderer = sim::MakeRenderer(scenario);
  // Both pictures are there even if the servo never had anything to report.
  sim::WorldView last = sim::World(scenario, Time{}).view();
  WritePicture(&renderer, last, folder.File("first.png"));
  sim::LockstepRun run = sim::RunLockstep(
      scenario,
      [&](const RunSample& sample, const ObservabilityReport& observability,
          const ServoStatus& status, sim::World& world) {
        last = world.view();
        console->Show(sample, observability, status);
      },
      until);
  WritePicture(&renderer, last, folder.File("last.png"));
  return run;
}

}  // namespace vantage
