// Rates of the batch evaluator beside other ways to compute the same w_c, in one run, with the peak rate of
// fused multiply-adds of this core as the yardstick. Prints a table after Google Benchmark's own lines.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <benchmark/benchmark.h>
#include <visp3/core/vpMatrix.h>
#include <visp3/core/vpVelocityTwistMatrix.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#ifdef __x86_64__
#include <immintrin.h>
#endif

#include "cell.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/math/angles.h"
#include "vantage/observability/batch.h"
#include "vantage/robot/kinematics.h"

namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using namespace vantage;  // NOLINT: a program of its own

constexpr int kSamples = 128;
constexpr int kCameras = 1024;
constexpr double kFocal = 600.0;

// ---- The motion: a PUMA 560 with three or six joints --------------------------------------------

struct Motion {
  std::vector<Vector3d> p_E;  // points on the end effector
  std::vector<BatchSample> samples;
  std::vector<ArmJacobian> J_r;
  std::vector<Isometry3d> X_WE;
  BatchScene scene;
  BatchObstacles obstacles;
};

Motion MakeMotion(int joints) {
  const ArmModel arm = test::Puma(joints);
  std::vector<Vector3d> p_E;
  if (joints == 3) {
    p_E = {{0, 0, 0}, {0, 0.1, 0}};
  } else {
    p_E = {{0.05, 0.05, 0.1}, {-0.05, 0.05, 0.1}, {-0.05, -0.05, 0.1}, {0.05, -0.05, 0.1}};
  }
  std::vector<BatchSample> samples;
  std::vector<BatchSight> sights;
  std::vector<ArmJacobian> J_r;
  std::vector<Isometry3d> X_WE;
  for (int i = 0; i < kSamples; ++i) {
    const double t = static_cast<double>(i) / (kSamples - 1);
    JointVector q(joints);
    for (int j = 0; j < joints; ++j) q(j) = 0.3 + 0.2 * j + (1.0 + 0.3 * j) * t;
    const Kinematics k = ComputeKinematics(arm, q);
    std::vector<PlacedCapsule> placed;
    PlaceCapsules(arm, q, &placed);
    BatchSample sample;
    sample.weight = 1.0 / kSamples;
    for (const Vector3d& p : p_E) {
      const Vector3d p_EP_W = k.X_WE.linear() * p;
      sample.p_W.push_back(k.X_WE.translation() + p_EP_W);
      sample.J_p_W.push_back(PointJacobianOf(k.J_WE_W, p_EP_W));
      BatchSight sight;
      sight.p_W = sample.p_W.back();
      for (const PlacedCapsule& c : placed) sight.capsules.push_back({c.p_WA, c.p_WB, c.radius});
      sights.push_back(sight);
    }
    samples.push_back(sample);
    J_r.push_back(k.J_WE_W);
    X_WE.push_back(k.X_WE);
  }
  return {p_E,
          samples,
          J_r,
          X_WE,
          BatchScene(samples, BatchBody::kRigid, test::PumaRows(joints), 2.0),
          BatchObstacles(sights, {}, 4.0, 2.0)};
}

const Motion& MotionOf(int joints) {
  static const Motion three = MakeMotion(3);
  static const Motion six = MakeMotion(6);
  return joints == 3 ? three : six;
}

// Cameras all round, every point in front of each.
const std::vector<Isometry3d>& Poses() {
  static const std::vector<Isometry3d> poses = [] {
    std::vector<Isometry3d> result;
    for (int i = 0; i < kCameras; ++i) {
      const double theta = std::acos(1.0 - 1.6 * (i + 0.5) / kCameras);
      const double phi = std::fmod(2.399963229728653 * i, 2.0 * kPi);
      result.push_back(SphericalPose(RigOrientation::kLookAt, Vector3d(0, 0, 0.6),
                                     {2.2 + 0.6 * (i % 7) / 7.0, theta, phi, 0.3}));
    }
    return result;
  }();
  return poses;
}

const BatchCameras& Cameras() {
  static const BatchCameras cameras = [] {
    BatchCameras result;
    result.Resize(kCameras);
    for (int i = 0; i < kCameras; ++i) result.Set(i, Poses()[i]);
    return result;
  }();
  return cameras;
}

BatchLens Lens() {
  BatchLens lens;
  lens.fx = lens.fy = kFocal;
  lens.x_min = lens.y_min = -0.5;
  lens.x_max = lens.y_max = 0.5;
  return lens;
}

// ---- Peers: one J_c at a time -------------------------------------------------------------------

// Rows of an interaction matrix that a motion of three joints uses: x1, y1, x2.
int RowsOf(int joints) {
  return joints == 3 ? 3 : 8;
}

MatrixXd DynamicJacobian(const Motion& motion, int i, const Isometry3d& X_WC, int rows) {
  const Matrix3d R_CW = X_WC.linear().transpose();
  MatrixXd J_v(2 * motion.p_E.size(), 6);
  for (std::size_t j = 0; j < motion.p_E.size(); ++j) {
    const Vector3d p = R_CW * (motion.samples[i].p_W[j] - X_WC.translation());
    MatrixXd D(2, 3);
    D << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z();
    const MatrixXd by_point = kFocal / p.z() * D * R_CW;
    J_v.block(2 * j, 0, 2, 3) = by_point;
    J_v.block(2 * j, 3, 2, 3) = -by_point * Skew(motion.X_WE[i].linear() * motion.p_E[j]);
  }
  return J_v.topRows(rows) * motion.J_r[i];
}

double DynamicSvd(const Motion& motion, int i, const Isometry3d& X_WC, int rows) {
  return Eigen::JacobiSVD<MatrixXd>(DynamicJacobian(motion, i, X_WC, rows)).singularValues().prod();
}

vpMatrix VispJacobian(const Motion& motion, int i, const Isometry3d& X_WC, int rows) {
  const Isometry3d X_CW = X_WC.inverse();
  vpHomogeneousMatrix cMe;
  const Isometry3d X_CE = X_CW * motion.X_WE[i];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) cMe[r][c] = X_CE(r, c);
  }
  vpMatrix eJe(6, static_cast<unsigned>(motion.J_r[i].cols()));
  const Matrix3d R_EW = motion.X_WE[i].linear().transpose();
  for (int c = 0; c < motion.J_r[i].cols(); ++c) {
    const Vector3d v = R_EW * motion.J_r[i].col(c).head<3>();
    const Vector3d w = R_EW * motion.J_r[i].col(c).tail<3>();
    for (int r = 0; r < 3; ++r) {
      eJe[r][c] = v(r);
      eJe[r + 3][c] = w(r);
    }
  }
  vpMatrix L;
  for (std::size_t j = 0; j < motion.p_E.size(); ++j) {
    const Vector3d p = X_CW * motion.samples[i].p_W[j];
    vpFeaturePoint point;
    point.buildFrom(p.x() / p.z(), p.y() / p.z(), p.z());
    const bool both = 2 * static_cast<int>(j) + 2 <= rows;
    L.stack(both ? point.interaction() : point.interaction(vpFeaturePoint::selectX()));
  }
  const vpVelocityTwistMatrix cVe(cMe);
  return -kFocal * (L * cVe * eJe);
}

double VispSvd(const Motion& motion, int i, const Isometry3d& X_WC, int rows) {
  vpMatrix J = VispJacobian(motion, i, X_WC, rows);
  vpColVector sigma;
  vpMatrix V;
  J.svd(sigma, V);
  double w = 1.0;
  for (unsigned k = 0; k < sigma.size(); ++k) w *= sigma[k];
  return w;
}

double VispDet(const Motion& motion, int i, const Isometry3d& X_WC, int rows) {
  const vpMatrix J = VispJacobian(motion, i, X_WC, rows);
  if (J.getRows() == J.getCols()) return std::abs(J.det());
  return std::sqrt(std::max(0.0, (J.t() * J).det()));
}

template <int kRows, int kJoints>
double FixedSize(const Motion& motion, int i, const Isometry3d& X_WC) {
  const Matrix3d R_CW = X_WC.linear().transpose();
  Eigen::Matrix<double, kRows, kJoints> J;
  for (int j = 0; 2 * j < kRows; ++j) {
    const Vector3d p = R_CW * (motion.samples[i].p_W[j] - X_WC.translation());
    const double v = kFocal / p.z();
    const Eigen::Matrix<double, 3, kJoints> A =
        R_CW * Eigen::Matrix<double, 3, kJoints>(motion.samples[i].J_p_W[j]);
    J.row(2 * j) = v * (A.row(0) - p.x() / p.z() * A.row(2));
    if (2 * j + 1 < kRows) J.row(2 * j + 1) = v * (A.row(1) - p.y() / p.z() * A.row(2));
  }
  if constexpr (kRows == kJoints) {
    return std::abs(J.determinant());
  } else {
    const Eigen::Matrix<double, kJoints, kJoints> G = J.transpose() * J;
    const Eigen::LLT<Eigen::Matrix<double, kJoints, kJoints>> llt(G);
    return llt.matrixLLT().diagonal().prod();
  }
}

template <typename W>
void Peer(benchmark::State& state, int joints, int cameras, W&& w) {
  const Motion& motion = MotionOf(joints);
  for (auto _ : state) {
    double sum = 0.0;
    for (int c = 0; c < cameras; ++c) {
      for (int i = 0; i < kSamples; ++i) sum += w(motion, i, Poses()[c]);
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * cameras * kSamples);
}

// ---- Peak: nothing but fused multiply-adds in registers -----------------------------------------

constexpr int kChains = 12;     // more than latency times ports
constexpr int kPerChain = 512;  // multiply-adds of each chain in one pass

#ifdef __x86_64__
__attribute__((target("avx512f"), noinline)) double PassAvx512(double seed) {
  __m512d x[kChains];
  for (int i = 0; i < kChains; ++i) x[i] = _mm512_set1_pd(seed + i);
  const __m512d a = _mm512_set1_pd(0.999), b = _mm512_set1_pd(0.001);
  for (int k = 0; k < kPerChain; ++k) {
#pragma GCC unroll 12
    for (int i = 0; i < kChains; ++i) x[i] = _mm512_fmadd_pd(x[i], a, b);
  }
  double sum = 0.0;
  for (int i = 0; i < kChains; ++i) sum += x[i][0] + x[i][7];
  return sum;
}
__attribute__((target("avx2,fma"), noinline)) double PassAvx2(double seed) {
  __m256d x[kChains];
  for (int i = 0; i < kChains; ++i) x[i] = _mm256_set1_pd(seed + i);
  const __m256d a = _mm256_set1_pd(0.999), b = _mm256_set1_pd(0.001);
  for (int k = 0; k < kPerChain; ++k) {
#pragma GCC unroll 12
    for (int i = 0; i < kChains; ++i) x[i] = _mm256_fmadd_pd(x[i], a, b);
  }
  double sum = 0.0;
  for (int i = 0; i < kChains; ++i) sum += x[i][0] + x[i][3];
  return sum;
}
#endif

constexpr int kPasses = 64;

double OperationsOfPasses(BatchIsa isa) {
  const double lanes = isa == BatchIsa::kAvx512 ? 8.0 : 4.0;
  return kPasses * kChains * kPerChain * lanes * 2.0;
}

void RunPasses(BatchIsa isa) {
  double seed = 1.0;
  for (int i = 0; i < kPasses; ++i) {
#ifdef __x86_64__
    seed = isa == BatchIsa::kAvx512 ? PassAvx512(seed) : PassAvx2(seed);
#endif
    seed = 1.0 + 1e-12 * seed;
  }
  benchmark::DoNotOptimize(seed);
}

void Peak(benchmark::State& state, BatchIsa isa) {
  for (auto _ : state) RunPasses(isa);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(OperationsOfPasses(isa)));
}

// Operations a second of the best instruction set: the best of many short runs, on an undisturbed core.
double PeakRate() {
  static const double rate = [] {
    const BatchIsa isa = AvailableIsas().back();
    double best = 0.0;
    for (int i = 0; i < 400; ++i) {
      const auto start = std::chrono::steady_clock::now();
      RunPasses(isa);
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      best = std::max(best, OperationsOfPasses(isa) / taken.count());
    }
    return best;
  }();
  return rate;
}

// Operations of one evaluation with its sum, a fused multiply-add counted as two; signs, comparisons and
// selections are not counted.
constexpr double kFlopsTriple = 51.0;
constexpr double kFlopsSix = 381.0;

// ---- The batch evaluator ------------------------------------------------------------------------

enum class Work { kPlain, kLeast, kFrustum, kOcclusion };

void Batch(benchmark::State& state, int joints, BatchIsa isa, BatchPrecision precision, Work work) {
  const Motion& motion = MotionOf(joints);
  const BatchEvaluator evaluator(isa);
  const BatchLens lens = Lens();
  BatchScores scores;
  BatchMargins margins;
  for (auto _ : state) {
    evaluator.Score(motion.scene, Cameras(), 0, kCameras, lens, BatchMeasure::kW, precision,
                    work == Work::kLeast, &scores);
    if (work == Work::kFrustum || work == Work::kOcclusion) {
      evaluator.CheckFrustum(motion.scene, Cameras(), 0, kCameras, lens, {0.3, 10.0}, precision,
                             &margins);
    }
    if (work == Work::kOcclusion) {
      evaluator.CheckObstacles(motion.obstacles, Cameras(), 0, kCameras, precision, &margins);
    }
    benchmark::DoNotOptimize(scores.sum.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kCameras * kSamples);
  if (work == Work::kPlain && precision == BatchPrecision::kDouble) {
    const double flops = joints == 3 ? kFlopsTriple : kFlopsSix;
    const double evaluations = static_cast<double>(state.iterations()) * kCameras * kSamples;
    state.counters["peak_share"] =
        benchmark::Counter(evaluations * flops / PeakRate(), benchmark::Counter::kIsRate);
  }
}

void Profiles(benchmark::State& state, int joints, bool with_gradient) {
  const Motion& motion = MotionOf(joints);
  const BatchEvaluator evaluator;
  BatchProfile profile;
  int camera = 0;
  for (auto _ : state) {
    evaluator.Profile(motion.scene, Poses()[camera], 1.0, Lens(), with_gradient, &profile);
    camera = (camera + 1) % kCameras;
    benchmark::DoNotOptimize(profile.w.data());
  }
  state.SetItemsProcessed(state.iterations() * kSamples);
}

// ---- Table --------------------------------------------------------------------------------------

// The rates this project set out to reach, on a core of 128 GFLOP/s.
constexpr double kGoalPeak = 128e9;

class BestRates : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      const auto items = run.counters.find("items_per_second");
      if (items == run.counters.end()) continue;
      double& best = rates_[run.run_name.function_name];
      best = std::max(best, items->second.value);
    }
    ConsoleReporter::ReportRuns(runs);
  }
  double operator[](const std::string& name) const {
    const auto found = rates_.find(name);
    return found == rates_.end() ? 0.0 : found->second;
  }

 private:
  std::map<std::string, double> rates_;
};

void PrintRow(const char* what, double rate, double reference, double goal, double peak,
              double flops) {
  std::printf("%-52s %9.2f", what, 1e-6 * rate);
  if (reference > 0.0) {
    std::printf(" %9.1f", rate / reference);
  } else {
    std::printf(" %9s", "");
  }
  if (goal > 0.0) {
    const double scaled = goal * peak / kGoalPeak;
    std::printf(" %9.0f %8.2f", goal, 1e-6 * rate / scaled);
  } else {
    std::printf(" %9s %8s", "", "");
  }
  if (flops > 0.0) {
    std::printf(" %7.0f %%", 100.0 * rate * flops / peak);
  }
  std::printf("\n");
}

void PrintTable(const BestRates& rates) {
  const double peak = rates["peak"];
  if (peak == 0.0) return;
  std::printf("\nPeak of this core: %.1f GFLOP/s in double precision (%s)\n", 1e-9 * peak,
              Name(AvailableIsas().back()).c_str());
  std::printf("Best of all repetitions, one core, %d samples, %d cameras\n", kSamples, kCameras);
  for (const int joints : {3, 6}) {
    const std::string prefix = joints == 3 ? "k3/" : "k8/";
    const double flops = joints == 3 ? kFlopsTriple : kFlopsSix;
    const double reference = rates[prefix + "eigen_svd"];
    const std::array<double, 3> goal =
        joints == 3 ? std::array<double, 3>{2003, 1363, 177} : std::array<double, 3>{181, 165, 67};
    std::printf("\n%-52s %9s %9s %9s %8s %9s\n",
                joints == 3 ? "w_c of k = 3, n = 3" : "w_c of k = 8, n = 6", "M/s", "x SVD", "goal",
                "reached", "of peak");
    const auto row = [&](const char* what, const char* name, double wanted, double counted) {
      if (rates[prefix + name] > 0.0) {
        PrintRow(what, rates[prefix + name], reference, wanted, peak, counted);
      }
    };
    row("dynamic Eigen, JacobiSVD", "eigen_svd", 0, 0);
    row("ViSP matrices, svd", "visp_svd", 0, 0);
    row("ViSP matrices, det", "visp_det", 0, 0);
    row("fixed-size Eigen, det or LLT", "eigen_fixed", 0, 0);
    row("batch, SSE2", "SSE2", 0, 0);
    row("batch, AVX2", "AVX2", 0, 0);
    row("batch, best instruction set", "plain", goal[0], flops);
    row("  with the least value too", "least", 0, 0);
    row("  + field of view and depth", "frustum", goal[1], 0);
    row("  + occlusion by three capsules", "occlusion", goal[2], 0);
    row("batch, single precision", "single", 0, 0);
    row("  + field of view and depth", "single_frustum", 0, 0);
    row("  + occlusion by three capsules", "single_occlusion", 0, 0);
    row("one camera, a sample in each lane", "profile", 0, 0);
    row("  with gradient", "gradient", 0, 0);
  }
  std::printf(
      "\ngoal: M/s on a core of %.0f GFLOP/s; reached: share of it, scaled to this core's peak\n",
      1e-9 * kGoalPeak);
}

void Register() {
  using benchmark::RegisterBenchmark;
  const BatchIsa best = AvailableIsas().back();
  RegisterBenchmark("peak", [best](benchmark::State& s) { Peak(s, best); });
  for (const int joints : {3, 6}) {
    const std::string prefix = joints == 3 ? "k3/" : "k8/";
    const int rows = RowsOf(joints);
    const auto peer = [&](const char* name, int cameras, auto w) {
      RegisterBenchmark((prefix + name).c_str(),
                        [joints, cameras, w](benchmark::State& s) { Peer(s, joints, cameras, w); });
    };
    peer("eigen_svd", 8,
         [rows](const Motion& m, int i, const Isometry3d& X) { return DynamicSvd(m, i, X, rows); });
    peer("visp_svd", 8,
         [rows](const Motion& m, int i, const Isometry3d& X) { return VispSvd(m, i, X, rows); });
    peer("visp_det", 8,
         [rows](const Motion& m, int i, const Isometry3d& X) { return VispDet(m, i, X, rows); });
    peer("eigen_fixed", 64, [joints](const Motion& m, int i, const Isometry3d& X) {
      return joints == 3 ? FixedSize<3, 3>(m, i, X) : FixedSize<8, 6>(m, i, X);
    });
    const auto batch = [&](const std::string& name, BatchIsa isa, BatchPrecision precision,
                           Work work) {
      RegisterBenchmark((prefix + name).c_str(),
                        [=](benchmark::State& s) { Batch(s, joints, isa, precision, work); });
    };
    for (const BatchIsa isa : AvailableIsas()) {
      if (isa != best) batch(Name(isa), isa, BatchPrecision::kDouble, Work::kPlain);
    }
    batch("plain", best, BatchPrecision::kDouble, Work::kPlain);
    batch("least", best, BatchPrecision::kDouble, Work::kLeast);
    batch("frustum", best, BatchPrecision::kDouble, Work::kFrustum);
    batch("occlusion", best, BatchPrecision::kDouble, Work::kOcclusion);
    batch("single", best, BatchPrecision::kSingle, Work::kPlain);
    batch("single_frustum", best, BatchPrecision::kSingle, Work::kFrustum);
    batch("single_occlusion", best, BatchPrecision::kSingle, Work::kOcclusion);
    for (const bool gradient : {false, true}) {
      RegisterBenchmark((prefix + (gradient ? "gradient" : "profile")).c_str(),
                        [=](benchmark::State& s) { Profiles(s, joints, gradient); });
    }
  }
}

// The routes compute one number, or the table would compare nothing.
bool RoutesAgree() {
  for (const int joints : {3, 6}) {
    const Motion& motion = MotionOf(joints);
    BatchScores scores;
    BatchEvaluator().Score(motion.scene, Cameras(), 0, 16, Lens(), BatchMeasure::kW,
                           BatchPrecision::kDouble, false, &scores);
    for (int c = 0; c < 16; ++c) {
      std::array<double, 4> sum{};
      for (int i = 0; i < kSamples; ++i) {
        const int rows = RowsOf(joints);
        const Isometry3d& X = Poses()[c];
        sum[0] += DynamicSvd(motion, i, X, rows);
        sum[1] += VispSvd(motion, i, X, rows);
        sum[2] += VispDet(motion, i, X, rows);
        sum[3] += joints == 3 ? FixedSize<3, 3>(motion, i, X) : FixedSize<8, 6>(motion, i, X);
      }
      for (const double s : sum) {
        if (!(std::abs(s / kSamples - scores.sum[c]) < 1e-6 * scores.sum[c])) {
          std::fprintf(stderr, "bench_plan: routes differ: %.12g and %.12g\n", s / kSamples,
                       scores.sum[c]);
          return false;
        }
      }
    }
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  // Short passes, often and in random order: the best of each is what an undisturbed core does.
  std::vector<char*> arguments(argv, argv + argc);
  std::string repetitions = "--benchmark_repetitions=15";
  std::string interleaving = "--benchmark_enable_random_interleaving=true";
  std::string time = "--benchmark_min_time=0.03";
  for (std::string* s : {&repetitions, &interleaving, &time}) {
    arguments.insert(arguments.begin() + 1, s->data());
  }
  int count = static_cast<int>(arguments.size());
  if (!RoutesAgree()) return 1;
  (void)PeakRate();  // before anything else warms or cools the core
  Register();
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  BestRates rates;
  benchmark::RunSpecifiedBenchmarks(&rates);
  PrintTable(rates);
  return 0;
}
