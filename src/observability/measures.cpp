#include "vantage/observability/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "singular_values.h"
#include "vantage/math/angles.h"
#include "vantage/math/spatial.h"

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

// Sum of the squares of all entries: finite and neither very large nor very small where the entries can be
// worked with as they are.
double SumOfSquares(const JacobianRef& J) noexcept {
  double sum = 0.0;
  for (int j = 0; j < J.cols(); ++j) sum += J.col(j).squaredNorm();
  return sum;
}

bool InBounds(double sum_of_squares) noexcept {
  return sum_of_squares > kSmallest && sum_of_squares < kLargest;
}

// The power of two that brings J into bounds; 0 where an entry is not finite.
double FactorIntoBounds(const JacobianRef& J) noexcept {
  if (InBounds(SumOfSquares(J))) return 1.0;
  double largest = 0.0;
  for (int j = 0; j < J.cols(); ++j) {
    const double* column = J.data() + j * J.outerStride();
    for (int i = 0; i < J.rows(); ++i) {
      if (!std::isfinite(column[i])) return 0.0;
      largest = std::max(largest, std::abs(column[i]));
    }
  }
  if (largest > kLargest || (largest < kSmallest && largest > 0.0)) {
    return std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1020, 1020));
  }
  return 1.0;
}

// Copies J, or its transpose where J is wide, times a power of two that brings it into bounds. *scale is
// that factor's inverse.
MeasureStatus Load(const JacobianRef& J, TallMatrix* A, double* scale) noexcept {
  const MeasureStatus status = CheckSize(J);
  if (status != MeasureStatus::kOk) return status;
  const double factor = FactorIntoBounds(J);
  if (factor == 0.0) return MeasureStatus::kNotFinite;
  *scale = 1.0 / factor;
  const auto rows = static_cast<int>(J.rows());
  const auto columns = static_cast<int>(J.cols());
  const bool tall = rows >= columns;
  A->rows = tall ? rows : columns;
  A->columns = tall ? columns : rows;
  for (int j = 0; j < columns; ++j) {
    const double* column = J.data() + j * J.outerStride();
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

void FillFromDiagonal(const double* diagonal, int s, double scale, Volume* volume) noexcept {
  volume->w = 1.0;
  for (int i = 0; i < s; ++i) volume->w *= scale * diagonal[i];
  volume->log_w = LogOfProduct(volume->w, s, [&](int i) { return scale * diagonal[i]; });
}

// From numbers whose product is w, as of a decomposition that does not sort out the rank. False where they leave
// doubt of it: the last singular value is w / |J|^(s-1) or more, so with w > tolerance |J|^s all of them count.
bool FillFromFactors(const double* factors, int s, double sum_of_squares, double rank_tolerance,
                     Volume* volume) noexcept {
  // With factors further apart than this too many digits of the least may be lost.
  constexpr double kClearFactor = 1e-4;
  const auto [least, largest] = std::minmax_element(factors, factors + s);
  if (!(*least > kClearFactor * *largest)) return false;
  double bound = rank_tolerance * rank_tolerance;  // squared
  for (int i = 0; i < s; ++i) bound *= sum_of_squares;
  FillFromDiagonal(factors, s, 1.0, volume);
  if (!(volume->w * volume->w > bound)) return false;
  volume->status = MeasureStatus::kOk;
  volume->rank = s;
  return true;
}

// False where the rows depend on each other, or nearly, or their size is out of bounds.
// @pre J fits into a RowBasis.
bool BasisOfRows(const JacobianRef& J, RowBasis* basis) noexcept {
  if (!InBounds(SumOfSquares(J))) return false;
  basis->rows = static_cast<int>(J.rows());
  basis->columns = static_cast<int>(J.cols());
  for (int i = 0; i < basis->rows; ++i) {
    for (int j = 0; j < kMaxJoints; ++j) basis->vector[i][j] = j < J.cols() ? J(i, j) : 0.0;
  }
  return FindRowBasis(basis);
}

double Square(double x) noexcept {
  return x * x;
}

// Share of the usual motion of the points below which a joint motion hardly moves them.
constexpr double kHardlyMoves = 0.02;

// Singular values squared of points that stand still, relative to the first: a ten millionth of the motion.
constexpr double kStandsStill = 1e-14;

// True when all eigenvalues of the symmetric S are above the bound: S - bound I has an L D Lᵀ factor with D > 0.
bool IsAbove(JointMatrix S, double bound) noexcept {
  const auto n = static_cast<int>(S.rows());
  S.diagonal().array() -= bound;
  for (int k = 0; k < n; ++k) {
    if (!(S(k, k) > 0.0)) return false;
    const double inverse = 1.0 / S(k, k);
    for (int j = k + 1; j < n; ++j) {
      const double factor = inverse * S(j, k);
      for (int i = j; i < n; ++i) S(i, j) -= factor * S(i, k);
    }
  }
  return true;
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

namespace {

// Numbers whose product is w, of a square J or a wide one of few rows: pivots, or what the rows add to the span
// of those before. How many they are; 0 of another matrix.
int FactorsOf(const JacobianRef& J, double sum_of_squares, double* factors) noexcept {
  const auto rows = static_cast<int>(J.rows());
  const auto columns = static_cast<int>(J.cols());
  if (rows < columns && rows <= RowBasis::kMaxVectors && columns <= kMaxJoints) {
    RowBasis basis;
    if (!BasisOfRows(J, &basis)) return 0;
    for (int i = 0; i < rows; ++i) factors[i] = basis.part[i][i];
    return rows;
  }
  if (rows != columns || rows > TallMatrix::kLanes || !InBounds(sum_of_squares)) return 0;
  TallMatrix A;
  A.rows = A.columns = rows;
  for (int j = 0; j < rows; ++j) {  // the transpose, which has the same determinant
    std::fill_n(A.row[j], TallMatrix::kLanes, 0.0);
    Eigen::Map<Eigen::VectorXd>(A.row[j], rows) = J.col(j);
  }
  Pivots(&A, factors);
  return rows;
}

}  // namespace

Volume VolumeOf(const JacobianRef& J, double rank_tolerance) noexcept {
  Volume volume;
  double factors[TallMatrix::kLanes];
  const double sum_of_squares = SumOfSquares(J);
  const int s = FactorsOf(J, sum_of_squares, factors);
  if (s > 0 && FillFromFactors(factors, s, sum_of_squares, rank_tolerance, &volume)) return volume;
  TallMatrix A;
  double scale = 1.0;
  volume.status = Load(J, &A, &scale);
  volume.log_w = -kInfinity;
  if (volume.status != MeasureStatus::kOk) return volume;
  double diagonal[TallMatrix::kMaxColumns];
  TriangleDiagonal(&A, diagonal);
  FillFromDiagonal(diagonal, A.columns, scale, &volume);
  volume.rank = static_cast<int>(std::count_if(diagonal, diagonal + A.columns, [&](double entry) {
    return entry > rank_tolerance * diagonal[0];
  }));
  return volume;
}

TaskJacobian VectorsOf(const SingularSystem& system) noexcept {
  // Made in their size and then filled: copies of a matrix of bounded size take all of its room along.
  const bool square = system.directions.rows() == system.directions.cols();
  const TaskJacobian& from = square ? system.directions : system.axes;
  TaskJacobian vectors(from.rows(), from.cols());
  vectors = from;
  if (!square) vectors.array().rowwise() /= system.measure.sigma.transpose().array();
  return vectors;
}

namespace {

// DecomposeNear() in place.
void DecomposeNearInto(const JacobianRef& J, const TaskJacobian& vectors,
                       SingularSystem* result) noexcept {
  const bool tall = J.rows() >= J.cols();
  const auto rows = static_cast<int>(tall ? J.rows() : J.cols());
  const auto columns = static_cast<int>(tall ? J.cols() : J.rows());
  const bool fits = columns >= 1 && columns <= ColumnMatrix::kMaxColumns && rows <= kMaxRows &&
                    vectors.rows() == columns && vectors.cols() == columns;
  if (!fits || !InBounds(SumOfSquares(J))) {
    *result = Decompose(J);
    return;
  }
  ColumnMatrix A;
  A.rows = rows;
  A.columns = columns;
  NearSystem near;
  using Vector = Eigen::Map<Eigen::VectorXd>;
  for (int j = 0; j < columns; ++j) {
    std::fill_n(near.vector[j], NearSystem::kVectorRows, 0.0);
    Vector(near.vector[j], columns) = vectors.col(j);
    Vector column(A.column[j], rows);
    if (tall) {
      column = J.col(j);
    } else {
      column = J.row(j).transpose();
    }
    for (int i = rows; i < PaddedRows(rows); ++i) A.column[j][i] = 0.0;
  }
  const bool solved = SolveNear(A, &near);
  // Of a lost direction a wide matrix has no image to take it from.
  if (!solved || (!tall && !(near.sigma[columns - 1] > kRankTolerance * near.sigma[0]))) {
    *result = Decompose(J);
    return;
  }
  Fill(near.sigma, 1.0, columns, kRankTolerance, &result->measure);
  result->axes.resize(J.rows(), columns);
  result->directions.resize(J.cols(), columns);
  TaskJacobian& images = tall ? result->axes : result->directions;
  TaskJacobian& found = tall ? result->directions : result->axes;
  for (int i = 0; i < columns; ++i) {
    images.col(i) = Vector(near.image[i], rows);
    found.col(i) = Vector(near.vector[i], columns);
    if (tall) continue;
    images.col(i) /= near.sigma[i];
    found.col(i) *= near.sigma[i];
  }
}

}  // namespace

SingularSystem DecomposeNear(const JacobianRef& J, const TaskJacobian& vectors) noexcept {
  SingularSystem result;
  DecomposeNearInto(J, vectors, &result);
  return result;
}

namespace {

// Vectors that go on as they went last time.
TaskJacobian GoneOn(const TaskJacobian& last, const TaskJacobian& earlier) noexcept {
  // Vectors that have changed places went nowhere.
  constexpr double kLongStep = 0.01;  // squared
  const bool known = last.rows() == earlier.rows() && last.cols() == earlier.cols();
  const bool near = known && (last - earlier).squaredNorm() < kLongStep;
  TaskJacobian vectors(last.rows(), last.cols());
  vectors = last;
  if (near) vectors += last - earlier;
  return vectors;
}

// B = J L, where L is the lower triangle of `basis`.
TaskJacobian TimesTriangle(const FeatureJacobian& J, const RowBasis& basis) noexcept {
  TaskJacobian B(J.rows(), kTaskDimension);
  for (int j = 0; j < kTaskDimension; ++j) {
    B.col(j) = basis.part[j][j] * J.col(j);
    for (int i = j + 1; i < kTaskDimension; ++i) B.col(j) += basis.part[i][j] * J.col(i);
  }
  return B;
}

using BasisVectors = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, kTaskDimension>,
                                Eigen::Aligned64, Eigen::OuterStride<kMaxJoints>>;

}  // namespace

void DecomposeComposite(const FeatureJacobian& J_v, const ArmJacobian& J_r, const TaskJacobian& J_c,
                        CompositeSystem* composite) noexcept {
  const auto n = static_cast<int>(J_r.cols());
  SingularSystem& system = composite->system;
  RowBasis basis;
  const bool redundant = n > kTaskDimension && J_v.rows() >= kTaskDimension;
  if (!redundant || !BasisOfRows(J_r, &basis)) {
    const TaskJacobian last = VectorsOf(system);
    const TaskJacobian near = GoneOn(last, composite->earlier);
    composite->earlier = last;
    DecomposeNearInto(J_c, near, &system);
    composite->arm = VolumeOf(J_r);
    return;
  }
  // J_r = L Qᵀ, so J_c = B Qᵀ with B = J_v L.
  const BasisVectors Q(basis.vector[0], n, kTaskDimension);
  TaskJacobian near(0, 0);
  if (system.directions.rows() == n) {
    near = Q.transpose().lazyProduct(GoneOn(system.directions, composite->earlier));
  }
  composite->earlier = system.directions;
  DecomposeNearInto(TimesTriangle(J_v, basis), near, &system);
  if (system.measure.status == MeasureStatus::kOk) {
    const TaskJacobian W = system.directions;
    system.directions = Q.lazyProduct(W);
  }
  double factors[kTaskDimension];
  for (int i = 0; i < kTaskDimension; ++i) factors[i] = basis.part[i][i];
  if (!FillFromFactors(factors, kTaskDimension, SumOfSquares(J_r), kRankTolerance,
                       &composite->arm)) {
    composite->arm = VolumeOf(J_r);
  }
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

namespace {

bool TooFewSeen(const SingularSystem& composite, int rows_needed) noexcept {
  return composite.measure.size() == 0 || composite.axes.rows() < rows_needed;
}

// Of eigenvalues of AᵀA, relative to their sum: above it none stands for points that stand still.
constexpr double kClearlyMoves = 100.0 * kStandsStill;

// Where the points move in as many directions as are seen: the cause by their squared motion along the direction that
// is seen worst, and in all of them.
LowCause CauseOfLeastSeen(double last, double trace, int joints) noexcept {
  const double usual = trace / static_cast<double>(std::min(joints, kTaskDimension));
  return last < Square(kHardlyMoves) * usual ? LowCause::kArm : LowCause::kView;
}

// The rules of DiagnoseLowMeasure() where some view may be to blame. With A of all points stacked:
//
// @param seen   (A V)ᵀ A V, V the directions of J_c.
// @param gram   AᵀA as a function: mostly it is not needed. Its eigenvalues are A's singular values squared.
// @param trace  Of AᵀA.
template <typename Gram>
LowCause CauseByMotion(const JointMatrix& seen, double trace, int joints, Gram&& gram) noexcept {
  const auto s = static_cast<int>(seen.rows());
  // The s-th eigenvalue of AᵀA is no less than the last one of `seen` (Cauchy), and its trace no less than its
  // first one.
  if (!IsAbove(seen, kClearlyMoves * trace)) {
    const Measure reach = MeasureOf(gram());
    const bool moves_in_all =
        s <= reach.size() && reach.sigma(s - 1) > kStandsStill * reach.sigma(0);
    if (!moves_in_all) return LowCause::kArm;
  }
  return CauseOfLeastSeen(seen(s - 1, s - 1), trace, joints);
}

// Σ PᵀP, P = [I, -[p]×] over points p of a body: of two twists, the sum of the products of all points' velocities.
class BodyMetric {
 public:
  explicit BodyMetric(const std::vector<Eigen::Vector3d>& points) noexcept
      : count_(static_cast<double>(points.size())) {
    for (const Eigen::Vector3d& p : points) {
      sum_ += p;
      inertia_.noalias() -= p * p.transpose();
      inertia_.diagonal().array() += p.squaredNorm();
    }
  }
  [[nodiscard]] Twist operator*(const Twist& twist) const noexcept {
    const Eigen::Vector3d v = twist.head<3>();
    const Eigen::Vector3d w = twist.tail<3>();
    Twist product;
    product << count_ * v + w.cross(sum_), sum_.cross(v) + inertia_ * w;
    return product;
  }
  // Of one twist, the sum of the points' squared velocities.
  [[nodiscard]] double Squared(const Twist& twist) const noexcept {
    const Eigen::Vector3d v = twist.head<3>();
    const Eigen::Vector3d w = twist.tail<3>();
    return count_ * v.squaredNorm() + 2.0 * v.dot(w.cross(sum_)) + w.dot(inertia_ * w);
  }
  // det M: that of the translations by that of the rotations about the points' middle.
  [[nodiscard]] double Determinant() const noexcept {
    Eigen::Matrix3d about_middle = inertia_ + sum_ * sum_.transpose() / count_;
    about_middle.diagonal().array() -= sum_.squaredNorm() / count_;
    return count_ * count_ * count_ * about_middle.determinant();
  }
  // Jᵀ M J.
  [[nodiscard]] JointMatrix Gram(const ArmJacobian& J) const noexcept {
    const auto n = static_cast<int>(J.cols());
    JointMatrix gram(n, n);
    for (int j = 0; j < n; ++j) {
      const Twist product = *this * J.col(j);
      for (int i = 0; i <= j; ++i) gram(i, j) = gram(j, i) = J.col(i).dot(product);
    }
    return gram;
  }

 private:
  double count_;
  Eigen::Vector3d sum_{Eigen::Vector3d::Zero()};
  Eigen::Matrix3d inertia_{Eigen::Matrix3d::Zero()};
};

}  // namespace

ArmJacobian TwistsOf(const SingularSystem& composite, const ArmJacobian& J_r) noexcept {
  const TaskJacobian& V = composite.directions;
  ArmJacobian twists(6, V.cols());
  for (int i = 0; i < V.cols(); ++i) {
    Twist twist = J_r.col(0) * V(0, i);
    for (int j = 1; j < J_r.cols(); ++j) twist += J_r.col(j) * V(j, i);
    twists.col(i) = twist;
  }
  return twists;
}

LowCause DiagnoseLowMeasure(const SingularSystem& composite,
                            const std::vector<PointJacobian>& points, int rows_needed,
                            bool low) noexcept {
  if (TooFewSeen(composite, rows_needed) || points.empty()) return LowCause::kFeatures;
  if (!low) return LowCause::kNone;
  const auto n = static_cast<int>(composite.directions.rows());
  JointMatrix gram = JointMatrix::Zero(n, n);
  for (const PointJacobian& A : points) gram.noalias() += A.transpose().lazyProduct(A);
  const auto& V = composite.directions;
  const TaskJacobian moved = gram.lazyProduct(V);
  return CauseByMotion(V.transpose().lazyProduct(moved), gram.trace(), n, [&] { return gram; });
}

LowCause DiagnoseLowMeasure(const SingularSystem& composite, const Volume& arm,
                            const ArmJacobian& J_r, const ArmJacobian& twists,
                            const std::vector<Eigen::Vector3d>& p_EP_W, int rows_needed,
                            bool low) noexcept {
  if (TooFewSeen(composite, rows_needed) || p_EP_W.empty()) return LowCause::kFeatures;
  if (!low) return LowCause::kNone;
  const BodyMetric metric(p_EP_W);
  const auto n = static_cast<int>(J_r.cols());
  const auto s = static_cast<int>(twists.cols());
  double trace = 0.0, last = 0.0;
  for (int i = 0; i < s; ++i) {
    last = metric.Squared(twists.col(i));
    trace += last;
  }
  // Directions that are all that joints can do to E: det Tᵀ M T = det M w_r². No eigenvalue is less than the product
  // of all by the mean of the others to their power.
  if (composite.measure.rank == kTaskDimension && s == kTaskDimension && arm.rank == s) {
    double least = metric.Determinant() * Square(arm.w);
    for (int i = 1; i < s; ++i) least *= (s - 1) / trace;
    if (least > kClearlyMoves * trace) return CauseOfLeastSeen(last, trace, n);
  }
  if (composite.measure.rank < std::min(n, kTaskDimension)) {
    trace = 0.0;
    for (int j = 0; j < n; ++j) trace += metric.Squared(J_r.col(j));
  }
  return CauseByMotion(metric.Gram(twists), trace, n, [&] { return metric.Gram(J_r); });
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

// Velocities of the points of a body by twists (v, ω) of it: v + ω × p.
class RigidMotions {
 public:
  void Set(int i, const Twist& twist) noexcept { rows_.col(i) = twist; }
  // B Bᵀ of the velocities B of a point, a column for each twist.
  [[nodiscard]] Eigen::Matrix3d SquaredAt(const Eigen::Vector3d& p) const noexcept {
    const Row x = X(p), y = Y(p), z = Z(p);
    Eigen::Matrix3d S;
    S(0, 0) = x.squaredNorm();
    S(1, 1) = y.squaredNorm();
    S(2, 2) = z.squaredNorm();
    S(0, 1) = S(1, 0) = x.dot(y);
    S(0, 2) = S(2, 0) = x.dot(z);
    S(1, 2) = S(2, 1) = y.dot(z);
    return S;
  }
  // Its trace.
  [[nodiscard]] double TotalAt(const Eigen::Vector3d& p) const noexcept {
    return (X(p).cwiseAbs2() + Y(p).cwiseAbs2() + Z(p).cwiseAbs2()).sum();
  }

 private:
  // Row by row: twists of one component in lanes.
  using Row = Eigen::Matrix<double, 1, kTaskDimension>;
  [[nodiscard]] Row X(const Eigen::Vector3d& p) const noexcept {
    return rows_.row(0) + p.z() * rows_.row(4) - p.y() * rows_.row(5);
  }
  [[nodiscard]] Row Y(const Eigen::Vector3d& p) const noexcept {
    return rows_.row(1) + p.x() * rows_.row(5) - p.z() * rows_.row(3);
  }
  [[nodiscard]] Row Z(const Eigen::Vector3d& p) const noexcept {
    return rows_.row(2) + p.y() * rows_.row(3) - p.x() * rows_.row(4);
  }

  Eigen::Matrix<double, 6, kTaskDimension, Eigen::RowMajor> rows_ =
      Eigen::Matrix<double, 6, kTaskDimension, Eigen::RowMajor>::Zero();
};

// Sum over all joints of the squared velocity of a point p of the body by each joint's twist.
double SquaredMotion(const ArmJacobian& twists, const Eigen::Vector3d& p) noexcept {
  double sum = 0.0;
  for (int j = 0; j < twists.cols(); ++j) {
    const auto twist = twists.col(j);
    sum += (twist.head<3>() + twist.tail<3>().cross(p)).squaredNorm();
  }
  return sum;
}

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
                                const ArmJacobian& twists,
                                const std::vector<Eigen::Vector3d>& p_EP_W) noexcept {
  const Measure& seen = composite.measure;
  if (seen.size() == 0) return p_EP_W.empty() ? 0.0 : kInfinity;
  // Twists of E by one pixel along each axis. Its six dimensions bound what J_c can see.
  const int rank = std::min(seen.rank, kTaskDimension);
  const auto n = static_cast<int>(J_r.cols());
  RigidMotions by_pixel;
  // Directions that fill all that joints can do to E leave nothing unseen.
  const bool leaves = rank < std::min(n, kTaskDimension);
  ArmJacobian unseen(6, 0);
  if (leaves) unseen = J_r;
  for (int i = 0; i < rank; ++i) {
    by_pixel.Set(i, twists.col(i) / seen.sigma(i));
    for (int j = 0; j < unseen.cols(); ++j) {
      unseen.col(j) -= composite.directions(j, i) * twists.col(i);
    }
  }
  if (leaves) {
    for (const Eigen::Vector3d& p : p_EP_W) {
      if (SquaredMotion(unseen, p) > kUnseen * SquaredMotion(J_r, p)) return kInfinity;
    }
  }
  // The point that is moved most comes first: mostly it is the worst, and a bound is enough for the others.
  if (p_EP_W.empty()) return 0.0;
  const Eigen::Vector3d* first = p_EP_W.data();
  double most = -1.0;
  for (const Eigen::Vector3d& p : p_EP_W) {
    const double moved = by_pixel.TotalAt(p);
    if (moved > most) {
      most = moved;
      first = &p;
    }
  }
  double worst = LargestEigenvalue(by_pixel.SquaredAt(*first));
  for (const Eigen::Vector3d& p : p_EP_W) {
    if (&p == first) continue;
    const Eigen::Matrix3d BBt = by_pixel.SquaredAt(p);
    if (!IsBelow(BBt, worst)) worst = std::max(worst, LargestEigenvalue(BBt));
  }
  return 1e3 * std::sqrt(worst);
}

}  // namespace vantage
