#include "run_lockstep.h"

#include <opencv2/imgcodecs.hpp>

#include "render_picture.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

void WritePicture(sim::Renderer* renderer, const sim::WorldView& view, const std::string& path) {
  if (!cv::imwrite(path, RenderPicture(renderer, view.X_WC, view.scene))) throw WriteError(path);
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
