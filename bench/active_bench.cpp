// One plan of the active camera: every view of the rig, scored along the motion that is still to come, with
// field of view, occlusion and the way there. What a running servo's planner thread does in one go.

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "vantage/active/view_planner.h"
#include "vantage/config/placement_file.h"
#include "vantage/config/scenario.h"

namespace {

using namespace vantage;  // NOLINT: a program of its own

constexpr int kStages = 16;

// Plans as they come along the scenario's motion, with the camera left where it starts.
std::vector<PlanRequest> RequestsOf(const std::string& name) {
  const PlacementProblem problem = LoadPlacement(name).problem;
  const JointVector q_start = problem.motion.samples.front().q;
  PlanRequest request;
  request.q_goal = problem.motion.samples.back().q;
  request.progress_rate = 1.0;
  request.goal_markers = problem.scene_markers;
  request.q_c = request.q_c_stay = problem.q_c_start;
  std::vector<PlanRequest> requests;
  for (int i = 0; i < kStages; ++i) {
    const double share = static_cast<double>(i) / kStages;
    request.q = q_start + share * (request.q_goal - q_start);
    requests.push_back(request);
  }
  return requests;
}

void Plan(benchmark::State& state, const std::string& name) {
  const Scenario scenario = LoadScenario(name);
  const std::vector<PlanRequest> requests = RequestsOf(name);
  const ActiveOptions& options = scenario.active;
  std::vector<double> milliseconds;
  double views = 0.0;
  std::size_t stage = 0;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    const ViewPlan plan = PlanView(scenario.task.view, scenario.rig, options.trigger,
                                   options.planner, requests[stage]);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    milliseconds.push_back(1e3 * took.count());
    views += plan.views_scored;
    stage = (stage + 1) % requests.size();
    state.SetIterationTime(took.count());
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  const auto at = [&](double share) {
    return milliseconds[static_cast<std::size_t>(share *
                                                 static_cast<double>(milliseconds.size() - 1))];
  };
  state.counters["median_ms"] = at(0.5);
  state.counters["p95_ms"] = at(0.95);
  state.counters["views"] = views / static_cast<double>(milliseconds.size());
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* name :
       {"planar-grazing-view", "puma3-bad-view", "puma560-bad-view", "panda-bad-view"}) {
    benchmark::RegisterBenchmark((std::string("plan/") + name).c_str(),
                                 [name](benchmark::State& state) { Plan(state, name); })
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime();
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
