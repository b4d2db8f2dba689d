#include "vantage/observability/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "singular_values.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Entries outside these bounds are scaled, so that their squares neither overflow nor vanish.
constexpr double kLargest = 1e120;
constexpr double kSmallest = 1e-120;

Measure Failed(MeasureStatus status) noexcept {
  Measure measure;
  measure.status = status;
  measure.sigma.resize(0);
  measure.log_w = -kInfinity;
  measure.condition = kInfinity;
  return measure;
}

MeasureStatus CheckSize(const JacobianRef& J) noexcept {
  const Eigen::Index least = std::min(J.rows(), J.cols());
  if (least == 0) return MeasureStatus::kEmpty;
  if (std::max(J.rows(), J.cols()) > kMaxRows || least > kMaxJoints)
    return MeasureStatus::kTooLarge;
  return MeasureStatus::kOk;
}

// Copies J, or its transpose where J is wide, times a power of two that brings it into bounds. *scale is
// that factor's inverse.
MeasureStatus Load(const JacobianRef& J, TallMatrix* A, double* scale) noexcept {
  const MeasureStatus status = CheckSize(J);
  if (status != MeasureStatus::kOk) return status;
  const auto rows = static_cast<int>(J.rows());
  const auto columns = static_cast<int>(J.cols());
  const auto stride = J.outerStride();
  const bool tall = rows >= columns;
  A->rows = tall ? rows : columns;
  A->columns = tall ? columns : rows;
  // Largest entry of each row of J, and NaN where one is not finite: 0 * inf is.
  std::array<double, kMaxRows> largest_in{};
  std::array<double, kMaxRows> zero{};
  for (int j = 0; j < columns; ++j) {
    const double* column = J.data() + j * stride;
    for (int i = 0; i < rows; ++i) {
      const double size = std::abs(column[i]);
      largest_in[i] = size > largest_in[i] ? size : largest_in[i];
      zero[i] += 0.0 * column[i];
    }
  }
  double largest = 0.0;
  double finite = 0.0;
  for (int i = 0; i < rows; ++i) {
    largest = std::max(largest, largest_in[i]);
    finite += zero[i];
  }
  if (!(finite == 0.0)) return MeasureStatus::kNotFinite;
  double factor = 1.0;
  if (largest > kLargest || (largest < kSmallest && largest > 0.0)) {
    factor = std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1020, 1020));
  }
  *scale = 1.0 / factor;
  for (int j = 0; j < columns; ++j) {
    const double* column = J.data() + j * stride;
    if (tall) {
      for (int i = 0; i < rows; ++i) A->row[i][j] = factor * column[i];
    } else {
      for (int i = 0; i < rows; ++i) A->row[j][i] = factor * column[i];
    }
  }
  for (int j = A->columns; j % TallMatrix::kLanes != 0; ++j) {
    for (int i = 0; i < A->rows; ++i) A->row[i][j] = 0.0;
  }
  return MeasureStatus::kOk;
}

// log of w = Π factor(i), i < s: one logarithm where the product kept its digits, s of them where it left
// the range of doubles.
template <typename Factor>
double LogOfProduct(double w, int s, Factor&& factor) noexcept {
  if (w > 1e-290 && w < 1e290) return std::log(w);
  double sum = 0.0;
  for (int i = 0; i < s; ++i) sum += std::log(factor(i));
  return sum;
}

// y = J x, column by column.
void MultiplyInto(const JacobianRef& J, const double* x, double* y) noexcept {
  const auto rows = static_cast<int>(J.rows());
  for (int i = 0; i < rows; ++i) y[i] = 0.0;
  for (int j = 0; j < J.cols(); ++j) {
    const double* column = J.data() + j * J.outerStride();
    for (int i = 0; i < rows; ++i) y[i] += x[j] * column[i];
  }
}

void Fill(const double* sigmas, double scale, int s, double rank_tolerance,
          Measure* measure) noexcept {
  measure->status = MeasureStatus::kOk;
  measure->sigma.resize(s);
  double w = 1.0;
  int rank = 0;
  const double least = rank_tolerance * sigmas[0];
  for (int i = 0; i < s; ++i) {
    const double sigma = sigmas[i];
    measure->sigma(i) = scale * sigma;
    w *= scale * sigma;
    if (sigma > least) ++rank;
  }
  measure->w = w;
  measure->log_w = LogOfProduct(w, s, [&](int i) { return measure->sigma(i); });
  measure->sigma_min = measure->sigma(s - 1);
  measure->condition =
      measure->sigma_min > 0.0 ? measure->sigma(0) / measure->sigma_min : kInfinity;
  measure->rank = rank;
}

// Writes to column i of V a unit vector orthogonal to the columns before it.
void CompleteBasis(TaskJacobian* V, int i) noexcept {
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRows, 1>;
  const auto before = V->leftCols(i);
  // The unit vector that has the least share in the span of the others.
  Eigen::Index axis = 0;
  before.rowwise().squaredNorm().minCoeff(&axis);
  Vector v = Vector::Unit(V->rows(), axis);
  for (int pass = 0; pass < 2; ++pass) {  // twice is enough for orthogonality to rounding
    for (int j = 0; j < i; ++j) v -= before.col(j).dot(v) * before.col(j);
    v.normalize();
  }
  V->col(i) = v;
}

double Square(double x) noexcept {
  return x * x;
}

// Share of the usual motion of the points below which a joint motion hardly moves them.
constexpr double kHardlyMoves = 0.02;

// Singular values squared of points that stand still, relative to the first: a ten millionth of the motion.
constexpr double kStandsStill = 1e-14;

// Whether the s-th eigenvalue of the symmetric, positive semidefinite G counts. Mostly a Cholesky factor
// settles it: that of G - c I is there only where all eigenvalues are above c.
bool MovesInAll(const JointMatrix& G, int s) noexcept {
  constexpr double kClearly = 100.0;
  if (s > G.rows()) return false;
  const double clearly =
      kClearly * kStandsStill * G.trace();  // the trace is above the first eigenvalue
  JointMatrix shifted = G;
  shifted.diagonal().array() -= clearly;
  if (clearly > 0.0 && Eigen::LLT<Eigen::Ref<JointMatrix>>(shifted).info() == Eigen::Success) {
    return true;
  }
  const Measure reach = MeasureOf(G);
  return s <= reach.size() && reach.sigma(s - 1) > kStandsStill * reach.sigma(0);
}

}  // namespace

const char* Name(LowCause cause) noexcept {
  switch (cause) {
    case LowCause::kNone:
      return "NONE";
    case LowCause::kView:
      return "VIEW";
    case LowCause::kArm:
      return "ARM";
    case LowCause::kFeatures:
      return "FEATURES";
  }
  return "UNKNOWN";
}

const char* Name(MeasureStatus status) noexcept {
  switch (status) {
    case MeasureStatus::kOk:
      return "OK";
    case MeasureStatus::kEmpty:
      return "EMPTY";
    case MeasureStatus::kNotFinite:
      return "NOT_FINITE";
    case MeasureStatus::kTooLarge:
      return "TOO_LARGE";
  }
  return "?";
}

const char* Name(GradientStatus status) noexcept {
  switch (status) {
    case GradientStatus::kOk:
      return "OK";
    case GradientStatus::kNotMeasured:
      return "NOT_MEASURED";
    case GradientStatus::kSingular:
      return "SINGULAR";
  }
  return "?";
}

double Measure::geometric_mean() const noexcept {
  return size() == 0 ? 0.0 : std::exp(log_w / size());
}

double Measure::inverse_condition() const noexcept {
  return sigma_min > 0.0 ? sigma_min / sigma(0) : 0.0;
}

double Measure::inverse_trace() const noexcept {
  double trace = 0.0;
  for (int i = 0; i < size(); ++i) {
    const double inverse = 1.0 / sigma(i);
    trace += inverse * inverse;
  }
  return trace;
}

Measure MeasureOf(const JacobianRef& J, int task_dimension, double rank_tolerance) noexcept {
  if (task_dimension < 1) return Failed(MeasureStatus::kEmpty);
  TallMatrix A;
  double scale = 1.0;
  const MeasureStatus status = Load(J, &A, &scale);
  if (status != MeasureStatus::kOk) return Failed(status);
  RightSystem system;
  const int s = std::min(A.columns, task_dimension);
  SolveRightSystem(&A, &system);
  Measure measure;
  Fill(system.sigma, scale, s, rank_tolerance, &measure);
  return measure;
}

Volume VolumeOf(const JacobianRef& J, double rank_tolerance) noexcept {
  Volume volume;
  TallMatrix A;
  double scale = 1.0;
  volume.status = Load(J, &A, &scale);
  volume.log_w = -kInfinity;
  if (volume.status != MeasureStatus::kOk) return volume;
  double diagonal[TallMatrix::kMaxColumns];
  TriangleDiagonal(&A, diagonal);
  volume.w = 1.0;
  volume.log_w = 0.0;
  for (int i = 0; i < A.columns; ++i) {
    volume.w *= scale * diagonal[i];
    if (diagonal[i] > rank_tolerance * diagonal[0]) ++volume.rank;
  }
  volume.log_w = LogOfProduct(volume.w, A.columns, [&](int i) { return scale * diagonal[i]; });
  return volume;
}

SingularSystem DecomposeNear(const JacobianRef& J, const TaskJacobian& directions) noexcept {
  const auto rows = static_cast<int>(J.rows());
  const auto columns = static_cast<int>(J.cols());
  const bool fits = rows >= columns && rows <= ShortMatrix::kMaxRows && columns >= 1 &&
                    columns <= kTaskDimension && directions.rows() == columns &&
                    directions.cols() == columns;
  if (!fits) return Decompose(J);
  const double size = J.squaredNorm();
  if (!(size > kSmallest && size < kLargest)) return Decompose(J);
  ShortMatrix A{};
  NearSystem near{};
  A.columns = columns;
  for (int j = 0; j < columns; ++j) {
    std::copy_n(J.data() + j * J.outerStride(), rows, A.column[j]);
    std::copy_n(directions.data() + j * directions.outerStride(), columns, near.vector[j]);
  }
  if (!SolveNear(A, &near)) return Decompose(J);
  SingularSystem result;
  Fill(near.sigma, 1.0, columns, kRankTolerance, &result.measure);
  result.axes.resize(rows, columns);
  result.directions.resize(columns, columns);
  for (int i = 0; i < columns; ++i) {
    std::copy_n(near.image[i], rows, result.axes.col(i).data());
    std::copy_n(near.vector[i], columns, result.directions.col(i).data());
  }
  return result;
}

SingularSystem Decompose(const JacobianRef& J, int task_dimension, double rank_tolerance) noexcept {
  SingularSystem result;
  result.axes.resize(0, 0);
  result.directions.resize(0, 0);
  TallMatrix A;
  double scale = 1.0;
  const MeasureStatus status = task_dimension < 1 ? MeasureStatus::kEmpty : Load(J, &A, &scale);
  if (status != MeasureStatus::kOk) {
    result.measure = Failed(status);
    return result;
  }
  RightSystem system;
  const int columns = A.columns;
  const int s = std::min(columns, task_dimension);
  SolveRightSystem(&A, &system);
  Fill(system.sigma, scale, s, rank_tolerance, &result.measure);

  const bool tall = J.rows() >= J.cols();
  const double zero = kRankTolerance * result.measure.sigma(0);
  result.axes.resize(J.rows(), s);
  result.directions.resize(J.cols(), s);
  for (int i = 0; i < s; ++i) {
    const Eigen::Map<const Eigen::VectorXd> vector(system.vector[i], columns);
    const double sigma = result.measure.sigma(i);
    if (tall) {
      if (sigma > 0.0) {
        result.directions.col(i) = vector;
      } else {
        CompleteBasis(&result.directions, i);
      }
      MultiplyInto(J, result.directions.col(i).data(), result.axes.col(i).data());
    } else {
      result.axes.col(i) = sigma * vector;
      if (sigma > zero) {
        result.directions.col(i).noalias() = J.transpose().lazyProduct(vector);
        result.directions.col(i) /= sigma;
      } else {
        CompleteBasis(&result.directions, i);
      }
    }
  }
  return result;
}

PseudoInverseMatrix PseudoInverse(const SingularSystem& system) noexcept {
  const auto rows = system.axes.rows();
  const auto columns = system.directions.rows();
  PseudoInverseMatrix inverse = PseudoInverseMatrix::Zero(columns, rows);
  for (int i = 0; i < system.measure.rank; ++i) {
    // v_i u_iᵀ / σ_i, with axes = σ_i u_i
    const double factor = 1.0 / Square(system.measure.sigma(i));
    inverse.noalias() +=
        (factor * system.directions.col(i)).lazyProduct(system.axes.col(i).transpose());
  }
  return inverse;
}

PseudoInverseMatrix EllipsoidMatrix(const SingularSystem& system) noexcept {
  const auto rows = system.axes.rows();
  PseudoInverseMatrix E = PseudoInverseMatrix::Zero(rows, rows);
  for (int i = 0; i < system.measure.rank; ++i) {
    const double factor = 1.0 / Square(Square(system.measure.sigma(i)));
    E.noalias() += (factor * system.axes.col(i)).lazyProduct(system.axes.col(i).transpose());
  }
  return E;
}

LogGradient GradientOfLog(const SingularSystem& system) noexcept {
  LogGradient gradient;
  gradient.by_J.resize(0, 0);
  const Measure& measure = system.measure;
  if (measure.status != MeasureStatus::kOk) return gradient;
  gradient.status = GradientStatus::kSingular;
  if (measure.rank < measure.size() || !(measure.sigma_min > 0.0)) return gradient;
  gradient.status = GradientStatus::kOk;
  gradient.by_J.setZero(system.axes.rows(), system.directions.rows());
  for (int i = 0; i < measure.size(); ++i) {
    const double factor = 1.0 / Square(measure.sigma(i));
    gradient.by_J.noalias() +=
        (factor * system.axes.col(i)).lazyProduct(system.directions.col(i).transpose());
  }
  return gradient;
}

double EllipsoidVolume(const Measure& measure) noexcept {
  if (measure.size() == 0) return 0.0;
  const double half = 0.5 * measure.size();
  return std::pow(kPi, half) / std::tgamma(half + 1.0) * measure.w;
}

ErrorBounds BoundErrors(const Measure& measure, int rows, int columns) noexcept {
  ErrorBounds bounds;
  bounds.lower_needs_range = rows > columns;
  bounds.upper_needs_minimum_norm = rows < columns;
  const bool moves = measure.size() > 0 && measure.sigma(0) > 0.0;
  bounds.lower = moves ? 1.0 / measure.sigma(0) : kInfinity;
  bounds.upper = moves && measure.rank == measure.size() ? 1.0 / measure.sigma_min : kInfinity;
  return bounds;
}

Coupling CouplingOf(const Measure& view, const Measure& arm, const Measure& composite) noexcept {
  Coupling coupling;
  if (!(composite.w > 0.0)) return coupling;
  if (view.w > 0.0 && arm.w > 0.0) {
    coupling.ratio = std::exp(composite.log_w - view.log_w - arm.log_w);
  }
  const int s = composite.size();
  if (s > view.size() || s > arm.size()) return coupling;
  double log_bound = 0.0;
  for (int i = 0; i < s; ++i) log_bound += std::log(view.sigma(i)) + std::log(arm.sigma(i));
  if (log_bound > -kInfinity) coupling.horn = std::min(1.0, std::exp(composite.log_w - log_bound));
  return coupling;
}

bool Whiten(const JacobianRef& covariance, TaskJacobian* J) noexcept {
  if (covariance.rows() != J->rows() || covariance.cols() != J->rows() ||
      covariance.rows() > kMaxRows || !covariance.allFinite()) {
    return false;
  }
  using Bounded =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows, kMaxRows>;
  const Eigen::LLT<Bounded> factor(covariance);
  if (factor.info() != Eigen::Success) return false;
  factor.matrixL().solveInPlace(*J);
  return true;
}

double CharacteristicLength(const ArmJacobian& J_r) noexcept {
  const double translation = J_r.topRows<3>().norm();
  const double rotation = J_r.bottomRows<3>().norm();
  const double length = translation / rotation;
  return length > 0.0 && length < kInfinity ? length : 1.0;
}

ArmJacobian ScaleTwistOfArm(const ArmJacobian& J_r, double length) noexcept {
  ArmJacobian scaled = J_r;
  scaled.bottomRows<3>() *= length;
  return scaled;
}

FeatureJacobian ScaleTwistOfImage(const FeatureJacobian& J_v, double length) noexcept {
  FeatureJacobian scaled = J_v;
  scaled.rightCols<3>() /= length;
  return scaled;
}

TaskJacobian ScaleJoints(const TaskJacobian& J, const JointVector& scale) noexcept {
  return J * scale.asDiagonal();
}

PointJacobian PointJacobianOf(const ArmJacobian& J_r, const Eigen::Vector3d& p_EP_W) noexcept {
  PointJacobian A(3, J_r.cols());
  for (Eigen::Index j = 0; j < J_r.cols(); ++j) {
    A.col(j) = J_r.col(j).head<3>() + J_r.col(j).tail<3>().cross(p_EP_W);
  }
  return A;
}

LowCause DiagnoseLowMeasure(const SingularSystem& composite,
                            const std::vector<PointJacobian>& points, int rows_needed,
                            bool low) noexcept {
  const Measure& seen = composite.measure;
  const int s = seen.size();
  if (s == 0 || composite.axes.rows() < rows_needed || points.empty()) return LowCause::kFeatures;
  if (!low) return LowCause::kNone;

  // Its eigenvalues are the squared singular values of the points' stacked Jacobians.
  const Eigen::Index n = composite.directions.rows();
  const auto worst_seen = composite.directions.col(s - 1);
  JointMatrix gram = JointMatrix::Zero(n, n);
  double moved = 0.0;
  for (const PointJacobian& A : points) {
    gram.noalias() += A.transpose().lazyProduct(A);
    moved += A.lazyProduct(worst_seen).squaredNorm();
  }
  if (!MovesInAll(gram, s)) return LowCause::kArm;
  const double usual =
      gram.trace() / static_cast<double>(std::min<Eigen::Index>(n, kTaskDimension));
  return moved < Square(kHardlyMoves) * usual ? LowCause::kArm : LowCause::kView;
}

namespace {

// Largest eigenvalue of a symmetric 3×3 matrix, by the cosine form of the cubic's roots.
double LargestEigenvalue(const Eigen::Matrix3d& S) noexcept {
  const double mean = S.trace() / 3.0;
  const Eigen::Matrix3d D = S - mean * Eigen::Matrix3d::Identity();
  const double spread = std::sqrt(D.squaredNorm() / 6.0);
  if (!(spread > 0.0)) return mean;
  const Eigen::Matrix3d N = D / spread;
  const double half_det = 0.5 * N.col(0).dot(N.col(1).cross(N.col(2)));
  return mean + 2.0 * spread * std::cos(std::acos(std::clamp(half_det, -1.0, 1.0)) / 3.0);
}

// What is left of a column after its share in the seen motions, to rounding (squared, relative).
constexpr double kUnseen = 1e-14;

// Velocities of the points of a body by up to C twists (v, ω) of it: v + ω × p.
template <int C>
class RigidMotions {
 public:
  template <typename Derived>
  void Set(int i, const Eigen::MatrixBase<Derived>& twist) noexcept {
    rows_.col(i) = twist;
  }
  // 3×C, row by row: twists of one component in lanes.
  using Velocities = Eigen::Matrix<double, 3, C, Eigen::RowMajor>;
  [[nodiscard]] Velocities At(const Eigen::Vector3d& p) const noexcept {
    Velocities moved = rows_.template topRows<3>();
    moved.row(0) += p.z() * rows_.row(4) - p.y() * rows_.row(5);
    moved.row(1) += p.x() * rows_.row(5) - p.z() * rows_.row(3);
    moved.row(2) += p.y() * rows_.row(3) - p.x() * rows_.row(4);
    return moved;
  }

 private:
  Eigen::Matrix<double, 6, C, Eigen::RowMajor> rows_ =
      Eigen::Matrix<double, 6, C, Eigen::RowMajor>::Zero();
};

// True when no eigenvalue of the symmetric S is `bound` or above: bound I - S is positive definite.
bool IsBelow(const Eigen::Matrix3d& S, double bound) noexcept {
  const double a = bound - S(0, 0);
  const double b = bound - S(1, 1);
  const double c = bound - S(2, 2);
  const double ab = a * b - S(0, 1) * S(0, 1);
  const double det =
      c * ab - a * S(1, 2) * S(1, 2) - b * S(0, 2) * S(0, 2) - 2.0 * S(0, 1) * S(1, 2) * S(0, 2);
  return a > 0.0 && ab > 0.0 && det > 0.0;
}

}  // namespace

double WorstMillimetresPerPixel(const SingularSystem& composite,
                                const std::vector<PointJacobian>& points) noexcept {
  const Measure& seen = composite.measure;
  if (seen.size() == 0) return points.empty() ? 0.0 : kInfinity;
  const int rank = seen.rank;
  double worst = 0.0;
  for (const PointJacobian& A : points) {
    // B = A V Σ^-1: motion of the point by one pixel along each axis.
    Eigen::Matrix3d BBt = Eigen::Matrix3d::Zero();
    double share = 0.0;
    for (int i = 0; i < rank; ++i) {
      const Eigen::Vector3d moved = A.lazyProduct(composite.directions.col(i));
      share += moved.squaredNorm();
      const Eigen::Vector3d b = moved / seen.sigma(i);
      BBt.noalias() += b * b.transpose();
    }
    const double all = A.squaredNorm();
    if (rank < A.cols() && all - share > kUnseen * all) return kInfinity;
    worst = std::max(worst, LargestEigenvalue(BBt));
  }
  return 1e3 * std::sqrt(worst);
}

double WorstMillimetresPerPixel(const SingularSystem& composite, const ArmJacobian& J_r,
                                const std::vector<Eigen::Vector3d>& p_EP_W) noexcept {
  const Measure& seen = composite.measure;
  if (seen.size() == 0) return p_EP_W.empty() ? 0.0 : kInfinity;
  const int rank = seen.rank;
  // Twists of E by one pixel along each axis. Its six dimensions bound what J_c can see.
  RigidMotions<kTaskDimension> by_pixel;
  ArmJacobian unseen = J_r;
  for (int i = 0; i < std::min(rank, kTaskDimension); ++i) {
    Eigen::Matrix<double, 6, 1> twist;
    MultiplyInto(J_r, composite.directions.col(i).data(), twist.data());
    by_pixel.Set(i, twist / seen.sigma(i));
    if (rank < J_r.cols()) {
      unseen.noalias() -= twist.lazyProduct(composite.directions.col(i).transpose());
    }
  }
  if (rank < J_r.cols()) {
    RigidMotions<kMaxJoints> lost, all;
    for (int j = 0; j < J_r.cols(); ++j) {
      lost.Set(j, unseen.col(j));
      all.Set(j, J_r.col(j));
    }
    for (const Eigen::Vector3d& p : p_EP_W) {
      if (lost.At(p).squaredNorm() > kUnseen * all.At(p).squaredNorm()) return kInfinity;
    }
  }
  double worst = 0.0;
  for (const Eigen::Vector3d& p : p_EP_W) {
    const auto moved = by_pixel.At(p);
    const Eigen::Matrix3d BBt = moved.lazyProduct(moved.transpose());
    if (!IsBelow(BBt, worst)) worst = std::max(worst, LargestEigenvalue(BBt));
  }
  return 1e3 * std::sqrt(worst);
}

}  // namespace vantage
