#include "singular_values.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Core>

namespace vantage {
namespace {

constexpr int kMax = TallMatrix::kMaxColumns;

// Rotations stop when no two columns were further from orthogonal than the square root of this before
// a sweep: convergence is quadratic, so that sweep left them orthogonal to rounding.
constexpr double kOrthogonal = 1e-17;
constexpr int kMaxSweeps = 40;
// Squared cosine of columns that are orthogonal to rounding.
constexpr double kRounding = 1e-32;

// A compile-time size where it is known lets the compiler unroll; 0 means known at run time.
template <int Static>
struct Size {
  int value;
  constexpr operator int() const noexcept { return Static > 0 ? Static : value; }  // NOLINT
};

// Columns of R^T, padded to an even number with zeros.
template <int Static>
struct Triangle {
  static constexpr int kStride = Static > 0 ? Static + Static % 2 : kMax;
  alignas(16) double column[kStride][kStride];
};

// Householder QR with column pivoting; writes R^T and the pivots.
template <int Static>
void PivotedQr(Size<Static> n, TallMatrix* A, Triangle<Static>* X, int* pivot) noexcept {
  const int m = A->rows;
  double norm2[kMax];
  for (int j = 0; j < n; ++j) {
    const double* a = A->column[j];
    norm2[j] = std::inner_product(a, a + m, a, 0.0);
    pivot[j] = j;
  }
  for (int j = 0; j < n; ++j) {
    const int best = static_cast<int>(std::max_element(norm2 + j, norm2 + n) - norm2);
    if (best != j) {
      std::swap_ranges(A->column[j], A->column[j] + m, A->column[best]);
      for (int i = 0; i < j; ++i) std::swap(X->column[i][j], X->column[i][best]);
      std::swap(norm2[j], norm2[best]);
      std::swap(pivot[j], pivot[best]);
    }
    double* h = A->column[j];
    const double norm = std::sqrt(norm2[j]);
    const double diagonal = h[j] > 0.0 ? -norm : norm;
    X->column[j][j] = diagonal;
    for (int i = 0; i < j; ++i) X->column[j][i] = 0.0;
    // Reflector I - h hᵀ / scale with h = a - diagonal e_j.
    const double scale = norm * (norm + std::abs(h[j]));
    h[j] -= diagonal;
    if (!(scale > 0.0)) {
      for (int c = j + 1; c < n; ++c) X->column[j][c] = 0.0;
      continue;
    }
    const double inverse = 1.0 / scale;
    for (int c = j + 1; c < n; ++c) {
      double* a = A->column[c];
      double dot = 0.0;
      for (int i = j; i < m; ++i) dot += h[i] * a[i];
      const double factor = dot * inverse;
      for (int i = j; i < m; ++i) a[i] -= factor * h[i];
      X->column[j][c] = a[j];
      double rest = 0.0;
      for (int i = j + 1; i < m; ++i) rest += a[i] * a[i];
      norm2[c] = rest;
    }
  }
}

// Rotates columns p and q until orthogonal. Returns the squared cosine between them before.
template <typename Column>
double Rotate(Column p, Column q) noexcept {
  const double pp = p.squaredNorm();
  const double qq = q.squaredNorm();
  const double pq = p.dot(q);
  const double squared = pq * pq;
  const double product = pp * qq;
  if (!(squared > kRounding * product)) return 0.0;  // orthogonal, or a column is 0
  const double difference = qq - pp;
  const double hypotenuse = std::sqrt(difference * difference + 4.0 * squared);
  const double tangent =
      std::copysign(2.0 * pq, difference * pq) / (std::abs(difference) + hypotenuse);
  const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
  const double sine = cosine * tangent;
  const typename Column::PlainObject old = p;
  p = cosine * old - sine * q;
  q = sine * old + cosine * q;
  return squared / product;
}

template <int Static>
void Solve(Size<Static> n, TallMatrix* A, RightSystem* system) noexcept {
  Triangle<Static> X;
  int pivot[kMax];
  PivotedQr(n, A, &X, pivot);

  // Rows are padded to an even number with zeros: two at a time.
  constexpr int kRows = Static > 0 ? Triangle<Static>::kStride : Eigen::Dynamic;
  using Storage = Eigen::Matrix<double, kRows, 1, Eigen::ColMajor, Triangle<Static>::kStride, 1>;
  using Column = Eigen::Map<Storage, Eigen::Aligned16>;
  const int rows = Static > 0 ? kRows : static_cast<int>(n);
  if (rows > n) {
    for (int j = 0; j < n; ++j) X.column[j][n] = 0.0;
  }
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double worst = 0.0;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) {
        worst = std::max(worst, Rotate(Column(X.column[p], rows), Column(X.column[q], rows)));
      }
    }
    if (worst <= kOrthogonal) break;
  }

  int order[kMax];
  double sigma[kMax];
  for (int j = 0; j < n; ++j) {
    order[j] = j;
    sigma[j] = std::sqrt(std::inner_product(X.column[j], X.column[j] + n, X.column[j], 0.0));
  }
  std::sort(order, order + n, [&](int a, int b) { return sigma[a] > sigma[b]; });
  for (int i = 0; i < n; ++i) {
    const int from = order[i];
    system->sigma[i] = sigma[from];
    const double inverse = sigma[from] > 0.0 ? 1.0 / sigma[from] : 0.0;
    for (int j = 0; j < n; ++j) system->vector[i][pivot[j]] = inverse * X.column[from][j];
  }
}

}  // namespace

void SolveRightSystem(TallMatrix* A, RightSystem* system) noexcept {
  switch (A->columns) {
    case 1:
      return Solve<1>({1}, A, system);
    case 2:
      return Solve<2>({2}, A, system);
    case 3:
      return Solve<3>({3}, A, system);
    case 4:
      return Solve<4>({4}, A, system);
    case 5:
      return Solve<5>({5}, A, system);
    case 6:
      return Solve<6>({6}, A, system);
    default:
      return Solve<0>({A->columns}, A, system);
  }
}

}  // namespace vantage
