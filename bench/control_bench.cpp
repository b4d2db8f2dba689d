// One control period beside ViSP's vpServo on the same task, in one run: from joints, camera pose and image points
// to joint velocities, with all measures. BM_Execution runs it at 1 kHz under the real-time scheduler and reports
// percentiles.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>
#include <visp3/core/vpMatrix.h>
#include <visp3/core/vpVelocityTwistMatrix.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#include <visp3/vs/vpServo.h>

#include "allocation_guard.h"
#include "vantage/config/loaders.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"
#include "vantage/runtime/periodic_loop.h"
#include "vantage/runtime/realtime.h"
#include "vantage/servo/camera_task.h"
#include "vantage/servo/servo.h"

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using namespace vantage;  // NOLINT: a program of its own

constexpr double kPeriod = 0.001;
constexpr int kLap = 768;  // periods from the start towards the goal, then from the start again
constexpr int kPeriodsPerPose = 5;    // 200 poses of the camera a second
constexpr int kPeriodsPerImage = 16;  // 60 images a second

// ---- The task: an arm that moves to a goal, a camera that looks at its hand -------------------------

JointVector Degrees(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  std::transform(values.begin(), values.end(), q.data(), [](double v) { return v * kPi / 180.0; });
  return q;
}

/// What an arm and a camera show on the way to the goal. No more of it than is used: neither ours nor the peer is to
/// wait for the memory that it lies in.
struct Lap {
  std::vector<JointVector> q;         // of each period
  std::vector<ImageFeatures> images;  // of each kPeriodsPerImage-th
};

struct Task {
  Task(int points, int joints)
      : arm(FindRobot(joints == 6 ? "puma560" : "panda")),
        view{arm, CameraModel(), FeatureSet::AllPoints(points), Markers(points)} {
    const JointVector q_0 = joints == 6 ? Degrees({10, 40, -120, 20, 50, 30})
                                        : Degrees({10, 20, -15, -110, 20, 130, 35});
    const Isometry3d X_WE = EndEffectorPose(arm, q_0);
    // One metre before the hand, a little to the side.
    const Vector3d p = X_WE * Vector3d(0.25, -0.15, 1.0);
    const Vector3d z = (X_WE.translation() - p).normalized();
    const Vector3d x = z.cross(X_WE.linear().col(1)).normalized();
    X_WC.linear() << x, z.cross(x), z;
    X_WC.translation() = p;
    JointVector q_goal = q_0;
    for (int j = 0; j < joints; ++j) q_goal(j) += j % 2 == 0 ? 0.08 : -0.08;
    p_WG = Points(q_goal);
    q_start = q_0;
  }

  [[nodiscard]] ImageFeatures ImageAt(const JointVector& q) const {
    ImageFeatures image;
    image.X_WC = X_WC;
    for (const Vector3d& p_WP : Points(q)) {
      MarkerMeasurement& marker = image.markers[static_cast<std::size_t>(image.count)];
      marker.id = image.count++;
      marker.pixel = ToPixel(view.camera, Project(X_WC.inverse() * p_WP)->n);
      marker.valid = true;
    }
    return image;
  }

  static std::vector<Marker> Markers(int points) {
    std::vector<Marker> markers(static_cast<std::size_t>(points));
    for (int i = 0; i < points; ++i) {
      markers[i].id = i;
      // Two rings, so that the points lie in no plane.
      const double angle = 2.0 * kPi * i / points;
      markers[i].p = {0.07 * std::cos(angle), 0.07 * std::sin(angle), i % 2 == 0 ? 0.02 : 0.05};
    }
    return markers;
  }

  [[nodiscard]] std::vector<Vector3d> Points(const JointVector& q) const {
    std::vector<Vector3d> points;
    const Isometry3d X_WE = EndEffectorPose(arm, q);
    for (const Marker& marker : view.markers) points.push_back(X_WE * marker.p);
    return points;
  }

  ArmModel arm;
  ViewModel view;
  Isometry3d X_WC{Isometry3d::Identity()};
  JointVector q_start;
  std::vector<Vector3d> p_WG;
};

// ---- Ours: all that vantage-servo does in a period --------------------------------------------------

ServoOptions OptionsWith(InteractionSource interaction) {
  ServoOptions options;
  options.period = kPeriod;
  options.interaction = interaction;
  return options;
}

ServoTask ServoTaskOf(const Task& task) {
  ServoGoal goal;
  goal.p_WG = task.p_WG;
  return {task.view, goal};
}

/// The servo over one lap of inputs, again and again.
class Ours {
 public:
  Ours(const Task& task, InteractionSource interaction)
      : task_(task),
        fresh_(ServoTaskOf(task), OptionsWith(interaction), TriggerOptions()),
        understudy_(fresh_) {
    Restart();
  }

  void Restart() {
    servo_.emplace(fresh_);
    now_ = Time(std::chrono::seconds(1));
    tick_ = 0;
  }
  /// As vantage-servo does ahead of a period.
  void Rehearse() {
    understudy_ = *servo_;
    understudy_.Rehearse(now_);
  }
  [[nodiscard]] bool AtEnd(const Lap& path) const { return tick_ == path.q.size(); }

  const ServoOutput& Step(const Lap& path) {
    const JointVector& q = path.q[tick_];
    servo_->Accept(JointState{now_, q, JointVector::Zero(q.size())}, now_);
    if (tick_ % kPeriodsPerPose == 0) servo_->Accept(CameraPose{now_, task_.X_WC}, now_);
    if (tick_ % kPeriodsPerImage == 0) {
      image_ = path.images[tick_ / kPeriodsPerImage];
      image_.stamp = image_.exposure = now_;
      servo_->Accept(image_, now_);
    }
    ++tick_;
    const ServoOutput& output = servo_->Step(now_);
    now_ += FromSeconds(kPeriod);
    return output;
  }

 private:
  const Task& task_;
  Servo fresh_;
  Servo understudy_;
  std::optional<Servo> servo_;
  ImageFeatures image_;
  Time now_;
  std::size_t tick_{0};
};

/// A lap: what an arm that does as it is told shows, one sample for each period.
Lap LapOf(const Task& task) {
  Ours ours(task, InteractionSource::kVisp);
  Lap path;
  JointVector q = task.q_start;
  for (int i = 0; i < kLap; ++i) {
    path.q.push_back(q);
    if (i % kPeriodsPerImage == 0) path.images.push_back(task.ImageAt(q));
    q += kPeriod * ours.Step(path).command.qdot;
  }
  return path;
}

/// Runs one lap. Empty if it servoed all the way, else what the servo did instead: one that holds is fast.
std::string Idleness(Ours* ours, const Lap& path) {
  ours->Restart();
  while (!ours->AtEnd(path)) {
    const ServoOutput& output = ours->Step(path);
    if (output.status.state == ServoState::kServoing && output.observability.w_c > 0.0) continue;
    return std::string("the servo does not servo: ") + Name(output.status.state) + " " +
           Name(output.status.reason);
  }
  ours->Restart();
  return "";
}

// ---- ViSP: vpServo, and the measures from its matrices ----------------------------------------------

class Visp {
 public:
  Visp(const Task& task, const Lap& path)
      : task_(task),
        path_(path),
        current_(task.p_WG.size()),
        wanted_(task.p_WG.size()),
        fJe_(6, static_cast<unsigned>(task.arm.size())) {
    servo_.setServo(vpServo::EYETOHAND_L_cVf_fJe);
    servo_.setInteractionMatrixType(vpServo::CURRENT, vpServo::PSEUDO_INVERSE);
    servo_.setLambda(3.0, 1.2, 2.0);
    for (std::size_t i = 0; i < current_.size(); ++i) servo_.addFeature(current_[i], wanted_[i]);
  }
  ~Visp() { servo_.kill(); }

  struct Output {
    vpColVector qdot, sigma_c;
    vpMatrix axes;
    double w_v, w_r, w_c, mm_per_px;
  };

  /// @param hidden_motion  Whether mm_per_px and the ellipsoid's axes are asked for too.
  Output Step(bool hidden_motion) {
    const Kinematics kinematics = ComputeKinematics(task_.arm, path_.q[++tick_ % path_.q.size()]);
    const Isometry3d X_CW = task_.X_WC.inverse();
    const Isometry3d X_CE = X_CW * kinematics.X_WE;
    for (std::size_t i = 0; i < current_.size(); ++i) {
      const Vector3d p = X_CE * task_.view.markers[i].p;
      current_[i].set_xyZ(p.x() / p.z(), p.y() / p.z(), p.z());
      const Vector3d g = X_CW * task_.p_WG[i];
      wanted_[i].set_xyZ(g.x() / g.z(), g.y() / g.z(), g.z());
    }
    // ViSP's f frame with the end effector's origin: the twist of E's origin in world axes.
    vpHomogeneousMatrix cMf;
    const Vector3d origin = X_CE.translation();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) cMf[r][c] = X_CW.linear()(r, c);
      cMf[r][3] = origin(r);
      for (int c = 0; c < task_.arm.size(); ++c) {
        fJe_[r][c] = kinematics.J_WE_W(r, c);
        fJe_[r + 3][c] = kinematics.J_WE_W(r + 3, c);
      }
    }
    const vpVelocityTwistMatrix cVf(cMf);
    servo_.set_cVf(cVf);
    servo_.set_fJe(fJe_);
    Output output;
    output.qdot = servo_.computeControlLaw();
    vpMatrix J_v = servo_.getInteractionMatrix() * cVf;
    output.w_v = Measure(J_v);
    vpMatrix J_r = fJe_;
    output.w_r = Measure(J_r);
    vpMatrix J_c = servo_.getTaskJacobian();
    output.w_c = Measure(J_c, &output.sigma_c, hidden_motion ? &output.axes : nullptr);
    output.mm_per_px = hidden_motion ? HiddenMotion(kinematics) : 0.0;
    return output;
  }

 private:
  // Of the markers' motions by one pixel of error, A J_c⁺, the largest singular value.
  double HiddenMotion(const Kinematics& kinematics) {
    const vpMatrix inverse = servo_.getTaskJacobianPseudoInverse();
    double worst = 0.0;
    for (const Marker& marker : task_.view.markers) {
      const Vector3d p = kinematics.X_WE.linear() * marker.p;
      vpMatrix to_point(3, 6);
      to_point.eye();
      to_point[0][4] = p.z();
      to_point[0][5] = -p.y();
      to_point[1][3] = -p.z();
      to_point[1][5] = p.x();
      to_point[2][3] = p.y();
      to_point[2][4] = -p.x();
      const vpMatrix moved = to_point * fJe_ * inverse;
      vpMatrix squared = moved.AAt();
      vpMatrix V;
      vpColVector values;
      squared.svd(values, V);
      worst = std::max(worst, values[0]);
    }
    return 1e3 * std::sqrt(worst) / task_.view.camera.fx;
  }

  static double Measure(const vpMatrix& J, vpColVector* sigma = nullptr, vpMatrix* axes = nullptr) {
    vpMatrix U = J.getRows() < J.getCols() ? J.t() : J;
    vpMatrix V;
    vpColVector values;
    U.svd(values, V);
    double w = 1.0;
    for (unsigned i = 0; i < std::min(values.size(), 6u); ++i) w *= values[i];
    if (sigma != nullptr) *sigma = values;
    if (axes != nullptr) {
      *axes = U;
      for (unsigned i = 0; i < axes->getRows(); ++i) {
        for (unsigned j = 0; j < axes->getCols(); ++j) (*axes)[i][j] *= values[j];
      }
    }
    return w;
  }

  const Task& task_;
  const Lap& path_;
  vpServo servo_;
  std::vector<vpFeaturePoint> current_, wanted_;
  vpMatrix fJe_;
  std::size_t tick_{0};
};

std::unique_ptr<Task> TaskOf(const benchmark::State& state) {
  return std::make_unique<Task>(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
}

template <InteractionSource kInteraction>
void BM_Period(benchmark::State& state) {
  const auto task = TaskOf(state);
  const Lap path = LapOf(*task);
  Ours ours(*task, kInteraction);
  if (const std::string idle = Idleness(&ours, path); !idle.empty()) {
    state.SkipWithError(idle.c_str());
    return;
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(ours.Step(path).command.qdot.data());
    if (!ours.AtEnd(path)) continue;
    state.PauseTiming();
    ours.Restart();
    state.ResumeTiming();
  }
  ours.Restart();
  const test::AllocationGuard guard;
  while (!ours.AtEnd(path)) (void)ours.Step(path);
  state.counters["allocations"] =
      static_cast<double>(guard.count()) / static_cast<double>(path.q.size());
}

// All that ours gives; without hidden motion: vpServo, w_v, w_r, w_c and the singular values alone.
template <bool kHiddenMotion>
void BM_VispPeriod(benchmark::State& state) {
  const auto task = TaskOf(state);
  const Lap path = LapOf(*task);
  Visp visp(*task, path);
  (void)visp.Step(kHiddenMotion);
  const test::AllocationGuard guard;
  for (auto _ : state) benchmark::DoNotOptimize(visp.Step(kHiddenMotion).w_c);
  state.counters["allocations"] =
      static_cast<double>(guard.count()) / static_cast<double>(state.iterations());
}

void Sizes(benchmark::internal::Benchmark* bench) {
  for (const int joints : {6, 7}) {
    for (const int points : {1, 4, 8, 16}) bench->Args({points, joints});
  }
}

BENCHMARK_TEMPLATE(BM_VispPeriod, true)->Apply(Sizes)->Name("BM_VispPeriod");
BENCHMARK_TEMPLATE(BM_VispPeriod, false)->Apply(Sizes)->Name("BM_VispPeriodWithoutHiddenMotion");
BENCHMARK_TEMPLATE(BM_Period, InteractionSource::kVisp)->Apply(Sizes)->Name("BM_Period");
BENCHMARK_TEMPLATE(BM_Period, InteractionSource::kClosedForm)
    ->Apply(Sizes)
    ->Name("BM_PeriodClosedForm");

// ---- Where the time goes -------------------------------------------------------------------------

void BM_Kinematics(benchmark::State& state) {
  const Task task(4, static_cast<int>(state.range(0)));
  const Lap path = LapOf(task);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(ComputeKinematics(task.arm, path.q[++i % path.q.size()]));
  }
}
BENCHMARK(BM_Kinematics)->Arg(6)->Arg(7);

// J_v, J_r and J_c of the task along its path.
struct Jacobians {
  FeatureJacobian J_v;
  ArmJacobian J_r;
  TaskJacobian J_c;
};

std::vector<Jacobians> JacobiansOf(const Task& task) {
  std::vector<Jacobians> all;
  for (const JointVector& q : LapOf(task).q) {
    const Kinematics kinematics = ComputeKinematics(task.arm, q);
    PointViews views;
    for (const Marker& marker : task.view.markers) {
      views.push_back(ViewOf(task.X_WC.inverse() * kinematics.X_WE * marker.p, true));
    }
    FeatureRows rows;
    task.view.features.Evaluate(task.view.camera, views, &rows);
    Jacobians J;
    J.J_v = ImageJacobian(rows.L_body, task.X_WC, kinematics.X_WE.translation());
    J.J_r = kinematics.J_WE_W;
    J.J_c = J.J_v * J.J_r;
    all.push_back(J);
  }
  return all;
}

template <typename Function>
void OverPath(benchmark::State& state, Function&& function) {
  const auto task = TaskOf(state);
  const std::vector<Jacobians> path = JacobiansOf(*task);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(function(path[++i % path.size()]));
}
void BM_DecomposeComposite(benchmark::State& state) {
  OverPath(state, [](const Jacobians& J) { return Decompose(J.J_c); });
}
void BM_VolumeOfView(benchmark::State& state) {
  OverPath(state, [](const Jacobians& J) { return VolumeOf(J.J_v); });
}
BENCHMARK(BM_DecomposeComposite)->Args({4, 6})->Args({4, 7});
BENCHMARK(BM_VolumeOfView)->Args({4, 6})->Args({16, 7});

// Gradient of log w_c by the joints: in closed form, and by central differences.
void BM_GradientOfComposite(benchmark::State& state) {
  const auto task = TaskOf(state);
  for (auto _ : state) {
    benchmark::DoNotOptimize(LogCompositeGradient(task->view, task->q_start, task->X_WC));
  }
}
void BM_GradientOfCompositeByDifferences(benchmark::State& state) {
  const auto task = TaskOf(state);
  const auto log_w = [&](const JointVector& q) {
    return MeasureOf(CompositeJacobian(task->view, SampleArm(task->view, q), task->X_WC)).log_w;
  };
  for (auto _ : state) {
    JointVector gradient(task->q_start.size());
    for (int i = 0; i < gradient.size(); ++i) {
      const JointVector step = 1e-4 * JointVector::Unit(gradient.size(), i);
      gradient(i) = (log_w(task->q_start + step) - log_w(task->q_start - step)) / 2e-4;
    }
    benchmark::DoNotOptimize(gradient.data());
  }
}
BENCHMARK(BM_GradientOfComposite)->Args({4, 7});
BENCHMARK(BM_GradientOfCompositeByDifferences)->Args({4, 7});

// ---- Execution times at 1 kHz ------------------------------------------------------------------------

constexpr Duration kExecutionRun = std::chrono::seconds(4);

// Work of the registers alone, some 3 us of it: what it takes longer at times is the machine's doing.
double Spin() {
  double x = 1.0;
  for (int i = 0; i < 2000; ++i) x = x * 0.999 + 0.5;
  return x;
}

// All take turns on one 4 kHz grid: each runs at 1 kHz, and what the machine does hits all alike.
struct Execution {
  DurationHistogram ours, closed_form, visp, machine;
  RealtimeReport granted;
};

// @param lead  Of rehearsals, each of what is run next; 0: none.
Execution RunExecution(Duration lead) {
  Execution result;
  std::thread control([&result, lead] {
    const Task task(4, 6);
    Ours ours(task, InteractionSource::kVisp);
    Ours closed_form(task, InteractionSource::kClosedForm);
    const Lap path = LapOf(task);
    Visp visp(task, path);
    result.granted = EnterRealtime(RealtimeOptions());
    std::atomic<bool> stop{false};
    const Time end = Clock::now() + kExecutionRun;
    constexpr int kTurns = 4;
    int turn = 0;
    const auto timed = [](DurationHistogram* histogram, auto&& step) {
      const Time begin = Clock::now();
      benchmark::DoNotOptimize(step());
      histogram->Add(Clock::now() - begin);
    };
    const auto period = [&] {
      if (turn == 0) timed(&result.ours, [&] { return ours.Step(path).observability.w_c; });
      if (turn == 1) {
        timed(&result.closed_form, [&] { return closed_form.Step(path).observability.w_c; });
      }
      if (turn == 2) timed(&result.visp, [&] { return visp.Step(true).w_c; });
      if (turn == 3) timed(&result.machine, Spin);
      turn = (turn + 1) % kTurns;
      for (Ours* one : {&ours, &closed_form}) {
        if (!one->AtEnd(path)) continue;
        one->Restart();
        (void)one->Step(path);  // that all is new at once is no period of a servo that runs
      }
      stop = Clock::now() >= end;
    };
    const auto rehearse = [&](Time) {
      if (turn == 0) ours.Rehearse();
      if (turn == 1) closed_form.Rehearse();
      if (turn == 2) benchmark::DoNotOptimize(visp.Step(true).w_c);
      if (turn == 3) benchmark::DoNotOptimize(Spin());
    };
    RunPeriodic(FromSeconds(kPeriod / kTurns), stop, period,
                Rehearsal<decltype(rehearse)>{lead, rehearse});
  });
  control.join();
  return result;
}

void BM_Execution(benchmark::State& state) {
  for (auto _ : state) {
    const Execution woken = RunExecution(Duration::zero());
    const Execution rehearsed = RunExecution(kRehearsalLead);
    const auto report = [&state](const std::string& name, const DurationHistogram& histogram) {
      for (const auto& [label, fraction] :
           {std::pair{"p50", 0.5}, {"p99", 0.99}, {"p999", 0.999}, {"max", 1.0}}) {
        state.counters[name + "_" + label + "_us"] =
            1e6 * ToSeconds(histogram.Percentile(fraction));
      }
    };
    report("ours", woken.ours);
    report("closed_form", woken.closed_form);
    report("visp", woken.visp);
    report("machine", woken.machine);
    report("rehearsed_ours", rehearsed.ours);
    report("rehearsed_closed_form", rehearsed.closed_form);
    report("rehearsed_visp", rehearsed.visp);
    report("rehearsed_machine", rehearsed.machine);
    state.counters["fifo"] = woken.granted.fifo && rehearsed.granted.fifo ? 1.0 : 0.0;
  }
}
BENCHMARK(BM_Execution)->Iterations(1)->Unit(benchmark::kSecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
