#pragma once

#include "singular_values.h"

/// @file
/// The kernels of singular_values.h, for registers of kWidth doubles. Included once in each translation
/// unit that is compiled for one instruction set; everything has internal linkage.

namespace vantage {
namespace {

constexpr int kMax = TallMatrix::kMaxColumns;

// Rotations stop when no two columns were further from orthogonal than the square root of this before
// a sweep: convergence is quadratic, so that sweep left them orthogonal to rounding.
constexpr double kOrthogonal = 1e-17;
constexpr int kMaxSweeps = 40;
// Squared cosine of columns that are orthogonal to rounding.
constexpr double kRounding = 1e-32;
// Half the tangent of the double angle below which a rotation's series are exact to rounding.
constexpr double kSmallAngle = 1.0 / 512.0;
// Squared cosine below which a rotation leaves columns the digits of their norms.
constexpr double kDistinct = 0.25;
// A squared norm that has shrunk by more is summed anew.
constexpr double kDigitsLeft = 1e-6;

alignas(64) constexpr double kIndex[kMax] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

typedef double V2 __attribute__((vector_size(16)));
typedef double V4 __attribute__((vector_size(32)));
typedef double V8 __attribute__((vector_size(64)));

template <int kWidth>
struct Register;
template <>
struct Register<2> {
  using Type = V2;
  static double Sum(V2 v) noexcept { return v[0] + v[1]; }
};
template <>
struct Register<4> {
  using Type = V4;
  static double Sum(V4 v) noexcept {
    return Register<2>::Sum(__builtin_shufflevector(v, v, 0, 1) +
                            __builtin_shufflevector(v, v, 2, 3));
  }
};
template <>
struct Register<8> {
  using Type = V8;
  static double Sum(V8 v) noexcept {
    return Register<4>::Sum(__builtin_shufflevector(v, v, 0, 1, 2, 3) +
                            __builtin_shufflevector(v, v, 4, 5, 6, 7));
  }
};

// kColumns doubles in as few registers as hold them.
template <int kWidth, int kColumns>
struct Lanes {
  static constexpr int kCount = (kColumns + kWidth - 1) / kWidth;
  using V = typename Register<kWidth>::Type;
  V v[kCount];

  static Lanes Load(const double* from) noexcept {
    Lanes x;
    for (int i = 0; i < kCount; ++i) x.v[i] = *reinterpret_cast<const V*>(from + i * kWidth);
    return x;
  }
  static Lanes Zero() noexcept {
    Lanes x;
    for (int i = 0; i < kCount; ++i) x.v[i] = V{};
    return x;
  }
  // 1 in column c, 0 elsewhere.
  static Lanes Unit(int c) noexcept {
    Lanes x;
    for (int i = 0; i < kCount; ++i) {
      const V at = *reinterpret_cast<const V*>(kIndex + i * kWidth);
      x.v[i] = at == static_cast<double>(c) ? V{} + 1.0 : V{};
    }
    return x;
  }
  void MultiplyBy(const Lanes& x) noexcept {
    for (int i = 0; i < kCount; ++i) v[i] *= x.v[i];
  }
  void Store(double* to) const noexcept {
    for (int i = 0; i < kCount; ++i) *reinterpret_cast<V*>(to + i * kWidth) = v[i];
  }
  // Adds a x.
  void Add(double a, const Lanes& x) noexcept {
    for (int i = 0; i < kCount; ++i) v[i] += a * x.v[i];
  }
  void Scale(double a) noexcept {
    for (int i = 0; i < kCount; ++i) v[i] *= a;
  }
  void AddSquaresOf(const Lanes& x, double sign) noexcept {
    for (int i = 0; i < kCount; ++i) v[i] += sign * (x.v[i] * x.v[i]);
  }
  [[nodiscard]] double Dot(const Lanes& x) const noexcept {
    V sum = v[0] * x.v[0];
    for (int i = 1; i < kCount; ++i) sum += v[i] * x.v[i];
    return Register<kWidth>::Sum(sum);
  }
};

// Householder QR with column pivoting, in place. Columns keep their places: row j comes out as row j of R
// for the columns not yet chosen and the one chosen in step j, 0 for those before. kColumns is the matrix'
// number of columns or, for all that have no case of their own, the most there can be.
template <int kWidth, int kColumns>
void PivotedQr(TallMatrix* A, double* diagonal) noexcept {
  using Row = Lanes<kWidth, kColumns>;
  const int m = A->rows;
  const int n = kColumns < kMax ? kColumns : A->columns;
  Row ahead = Row::Zero();  // 1 for columns not yet chosen
  for (int c = 0; c < n; ++c) ahead.Add(1.0, Row::Unit(c));
  Row rest;  // squared norm of what is left of each column
  alignas(64) double rest_of[kMax + TallMatrix::kLanes];
  const auto sum_rest = [&](int from) {
    rest = Row::Zero();
    for (int i = from; i < m; ++i) rest.AddSquaresOf(Row::Load(A->row[i]), 1.0);
    rest.MultiplyBy(ahead);
  };
  const auto largest_rest = [&] {
    rest.Store(rest_of);
    int best = 0;
    for (int c = 1; c < n; ++c) best = rest_of[c] > rest_of[best] ? c : best;
    return best;
  };
  sum_rest(0);

  double h[kMaxRows];
  double first = 0.0;
  for (int j = 0; j < n; ++j) {
    int best = largest_rest();
    if (j == 0) first = rest_of[best];
    if (rest_of[best] < kDigitsLeft * first) {
      // So much was subtracted that the choice would be one among rounding errors.
      sum_rest(j);
      best = largest_rest();
      // Nothing but zeros is left: any column not yet chosen.
      if (!(rest_of[best] > 0.0)) {
        ahead.Store(rest_of);
        for (best = 0; rest_of[best] == 0.0;) ++best;
      }
    }
    // Afresh: what was subtracted from `rest` has cost it digits. Sums in two halves: they overlap in time.
    double norm2[2] = {0.0, 0.0};
    for (int i = j; i < m; ++i) {
      h[i] = A->row[i][best];
      norm2[i % 2] += h[i] * h[i];
    }
    const double norm = __builtin_sqrt(norm2[0] + norm2[1]);
    diagonal[j] = h[j] > 0.0 ? -norm : norm;
    // Reflector I - h hᵀ / scale with h = a - diagonal e_j.
    const double scale = norm * (norm + __builtin_fabs(h[j]));
    h[j] -= diagonal[j];
    Row row = Row::Load(A->row[j]);
    if (scale > 0.0) {
      Row even = Row::Zero();
      Row odd = Row::Zero();
      int i = j;
      for (; i + 1 < m; i += 2) {
        even.Add(h[i], Row::Load(A->row[i]));
        odd.Add(h[i + 1], Row::Load(A->row[i + 1]));
      }
      if (i < m) even.Add(h[i], Row::Load(A->row[i]));
      even.Add(1.0, odd);
      even.Scale(1.0 / scale);
      row.Add(-h[j], even);
      for (i = j + 1; i < m; ++i) {
        Row below = Row::Load(A->row[i]);
        below.Add(-h[i], even);
        below.Store(A->row[i]);
      }
    }
    ahead.Add(-1.0, Row::Unit(best));
    row.MultiplyBy(ahead);
    rest.AddSquaresOf(row, -1.0);
    rest.MultiplyBy(ahead);
    row.Add(diagonal[j], Row::Unit(best));
    row.Store(A->row[j]);
  }
}

// Rotates columns p and q until orthogonal; their squared norms follow. True when they were before, as
// far as `orthogonal` says: their squared cosine.
template <typename Column>
bool Rotate(double orthogonal, Column* p, Column* q, double* pp, double* qq) noexcept {
  const double pq = p->Dot(*q);
  const double squared = pq * pq;
  const double product = *pp * *qq;
  if (!(squared > kRounding * product)) return true;  // orthogonal, or a column is 0
  const double difference = *qq - *pp;
  const Column old_p = *p;
  const Column old_q = *q;
  const auto turn = [&](double cosine, double sine) {
    p->Scale(cosine);
    p->Add(-sine, old_q);
    q->Scale(cosine);
    q->Add(sine, old_p);
  };
  if (__builtin_fabs(pq) < kSmallAngle * __builtin_fabs(difference)) {
    // Nearly all rotations but the first sweeps': series of θ = atan(2 y) / 2 without roots, exact to
    // rounding.
    const double y = pq * (1.0 / difference);
    const double y2 = y * y;
    turn(1.0 - y2 * (0.5 - 1.375 * y2), y * (1.0 - y2 * (1.5 - 3.875 * y2)));
    if (squared < kDistinct * product) {
      const double moved = pq * y * (1.0 - y2 * (1.0 - 2.0 * y2));  // tan θ times p·q
      *pp -= moved;
      *qq += moved;
      return squared <= orthogonal * product;
    }
  } else {
    const double hypotenuse = __builtin_sqrt(difference * difference + 4.0 * squared);
    const double tangent =
        __builtin_copysign(2.0 * pq, difference * pq) / (__builtin_fabs(difference) + hypotenuse);
    const double cosine = 1.0 / __builtin_sqrt(1.0 + tangent * tangent);
    turn(cosine, cosine * tangent);
  }
  // Afresh: of two nearly parallel columns little is left of one.
  *pp = p->Dot(*p);
  *qq = q->Dot(*q);
  return false;
}

// The pairs of columns in the order of a round robin: those of one round share no column, so that their
// rotations overlap in time.
template <int kColumns>
struct RoundRobin {
  static constexpr int kCount = kColumns * (kColumns - 1) / 2;
  int p[kCount > 0 ? kCount : 1]{};
  int q[kCount > 0 ? kCount : 1]{};

  constexpr RoundRobin() {
    constexpr int kPlayers = kColumns + kColumns % 2;
    int pair = 0;
    for (int round = 0; round < kPlayers - 1; ++round) {
      for (int k = 0; k < kPlayers / 2; ++k) {
        const int a = k == 0 ? kPlayers - 1 : (round + k) % (kPlayers - 1);
        const int b = (round + kPlayers - 1 - k) % (kPlayers - 1);
        if (a >= kColumns || b >= kColumns) continue;  // an odd one sits out
        p[pair] = a < b ? a : b;
        q[pair] = a < b ? b : a;
        ++pair;
      }
    }
  }
};

// One sweep over all pairs of the n columns. True when all were as orthogonal before.
template <int kColumns, typename Column>
bool Sweep(double orthogonal, int n, Column* x) noexcept {
  static constexpr RoundRobin<kColumns> kPairs;
  double norm2[kMax];
  for (int j = 0; j < n; ++j) norm2[j] = x[j].Dot(x[j]);
  bool all = true;
#pragma GCC unroll 32
  for (int i = 0; i < RoundRobin<kColumns>::kCount; ++i) {
    const int p = kPairs.p[i];
    const int q = kPairs.q[i];
    if (kColumns == kMax && q >= n) continue;
    all &= Rotate(orthogonal, &x[p], &x[q], &norm2[p], &norm2[q]);
  }
  return all;
}

template <int kWidth, int kColumns>
void Solve(TallMatrix* A, RightSystem* system) noexcept {
  using Column = Lanes<kWidth, kColumns>;
  const int n = kColumns < kMax ? kColumns : A->columns;
  double diagonal[kMax];
  PivotedQr<kWidth, kColumns>(A, diagonal);

  // The columns of Rᵀ are the rows of R.
  Column x[kColumns];
  for (int j = 0; j < n; ++j) x[j] = Column::Load(A->row[j]);
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    if (Sweep<kColumns>(kOrthogonal, n, x)) break;
  }

  int order[kMax];
  double sigma[kMax];
  Sort(n, x, sigma, order);
  for (int i = 0; i < n; ++i) {
    const int from = order[i];
    system->sigma[i] = sigma[from];
    x[from].Scale(sigma[from] > 0.0 ? 1.0 / sigma[from] : 0.0);
    x[from].Store(system->vector[i]);
  }
}

// σ_j from the columns x, and their order by falling σ.
template <typename Column>
void Sort(int n, const Column* x, double* sigma, int* order) noexcept {
  for (int j = 0; j < n; ++j) {
    sigma[j] = __builtin_sqrt(x[j].Dot(x[j]));
    int place = j;  // insertion: few, and nearly sorted
    for (; place > 0 && sigma[order[place - 1]] < sigma[j]; --place) {
      order[place] = order[place - 1];
    }
    order[place] = j;
  }
}

// A v beside v, rotated together; products are those of A v.
template <int kWidth, int kRows>
struct ImagePair {
  Lanes<kWidth, kRows> image;
  Lanes<kWidth, NearSystem::kVectorRows> vector;

  void Add(double a, const ImagePair& x) noexcept {
    image.Add(a, x.image);
    vector.Add(a, x.vector);
  }
  void Scale(double a) noexcept {
    image.Scale(a);
    vector.Scale(a);
  }
  [[nodiscard]] double Dot(const ImagePair& x) const noexcept { return image.Dot(x.image); }
};

// Vectors that are further from orthonormal than this (squared) are no guess.
constexpr double kNearlyOrthonormal = 1e-8;
// From nearer than this (squared) a step of Orthonormalise() leaves rounding.
constexpr double kStepFromRounding = 1e-16;
// As kOrthogonal: the sweep leaves them orthogonal to some ten roundings, which spares a sweep here.
constexpr double kNearlyOrthogonal = 1e-15;
constexpr int kMaxNearSweeps = 5;

// One step of Newton and Schulz, V (3 I - VᵀV) / 2: what was off by e is off by e² afterwards. e², not finite for
// what is not finite.
template <int kColumns, typename Vector>
double Orthonormalise(Vector* v) noexcept {
  Vector old[kColumns];
  for (int i = 0; i < kColumns; ++i) old[i] = v[i];
  double off2 = 0.0;
  for (int i = 0; i < kColumns; ++i) {
    for (int j = i; j < kColumns; ++j) {
      const double e = old[i].Dot(old[j]) - (i == j ? 1.0 : 0.0);
      off2 += e * e;
      v[i].Add(-0.5 * e, old[j]);
      if (i != j) v[j].Add(-0.5 * e, old[i]);
    }
  }
  return off2;
}

template <int kWidth, int kColumns, int kRows>
bool Near(const ColumnMatrix& A, NearSystem* system) noexcept {
  using Image = Lanes<kWidth, kRows>;
  using Vector = Lanes<kWidth, NearSystem::kVectorRows>;
  Vector v[kColumns];
  for (int i = 0; i < kColumns; ++i) v[i] = Vector::Load(system->vector[i]);
  for (double off2 = 1.0; !(off2 < kStepFromRounding);) {
    off2 = Orthonormalise<kColumns>(v);
    if (!(off2 < kNearlyOrthonormal)) return false;
  }
  ImagePair<kWidth, kRows> x[kColumns];
  for (int i = 0; i < kColumns; ++i) {
    x[i].vector = v[i];
    x[i].vector.Store(system->vector[i]);
    x[i].image = Image::Zero();
    for (int j = 0; j < kColumns; ++j) {
      x[i].image.Add(system->vector[i][j], Image::Load(A.column[j]));
    }
  }
  int sweep = 0;
  while (!Sweep<kColumns>(kNearlyOrthogonal, kColumns, x)) {
    if (++sweep == kMaxNearSweeps) return false;
  }
  int order[kColumns];
  double sigma[kColumns];
  Sort(kColumns, x, sigma, order);
  for (int i = 0; i < kColumns; ++i) {
    const int from = order[i];
    system->sigma[i] = sigma[from];
    x[from].image.Store(system->image[i]);
    x[from].vector.Store(system->vector[i]);
  }
  return true;
}

template <int kWidth, int kColumns>
void Diagonal(TallMatrix* A, double* diagonal) noexcept {
  PivotedQr<kWidth, kColumns>(A, diagonal);
  for (int j = 0; j < A->columns; ++j) diagonal[j] = __builtin_fabs(diagonal[j]);
}

// A case for each usual number of columns, and one for all the others.
template <int kWidth>
void SolveAny(TallMatrix* A, RightSystem* system) noexcept {
  using Case = void (*)(TallMatrix*, RightSystem*) noexcept;
  static constexpr Case kCases[] = {Solve<kWidth, 1>, Solve<kWidth, 2>, Solve<kWidth, 3>,
                                    Solve<kWidth, 4>, Solve<kWidth, 5>, Solve<kWidth, 6>,
                                    Solve<kWidth, 7>, Solve<kWidth, 8>};
  A->columns <= 8 ? kCases[A->columns - 1](A, system) : Solve<kWidth, kMax>(A, system);
}

template <int kWidth>
void DiagonalOfAny(TallMatrix* A, double* diagonal) noexcept {
  using Case = void (*)(TallMatrix*, double*) noexcept;
  static constexpr Case kCases[] = {Diagonal<kWidth, 1>, Diagonal<kWidth, 2>, Diagonal<kWidth, 3>,
                                    Diagonal<kWidth, 4>, Diagonal<kWidth, 5>, Diagonal<kWidth, 6>,
                                    Diagonal<kWidth, 7>, Diagonal<kWidth, 8>};
  A->columns <= 8 ? kCases[A->columns - 1](A, diagonal) : Diagonal<kWidth, kMax>(A, diagonal);
}

template <int kWidth, int kRows>
bool NearOf(const ColumnMatrix& A, NearSystem* system) noexcept {
  using Case = bool (*)(const ColumnMatrix&, NearSystem*) noexcept;
  static constexpr Case kCases[] = {Near<kWidth, 1, kRows>, Near<kWidth, 2, kRows>,
                                    Near<kWidth, 3, kRows>, Near<kWidth, 4, kRows>,
                                    Near<kWidth, 5, kRows>, Near<kWidth, 6, kRows>};
  return kCases[A.columns - 1](A, system);
}

template <int kWidth>
bool NearAny(const ColumnMatrix& A, NearSystem* system) noexcept {
  const int rows = PaddedRows(A.rows);
  return rows == 8    ? NearOf<kWidth, 8>(A, system)
         : rows == 16 ? NearOf<kWidth, 16>(A, system)
                      : NearOf<kWidth, kMaxRows>(A, system);
}

template <int kWidth>
void PivotsOfAny(TallMatrix* A, double* pivots) noexcept {
  using Row = Lanes<kWidth, TallMatrix::kLanes>;
  const int n = A->columns;
  for (int j = 0; j < n; ++j) {
    int best = j;
    for (int i = j + 1; i < n; ++i) {
      best = __builtin_fabs(A->row[i][j]) > __builtin_fabs(A->row[best][j]) ? i : best;
    }
    const Row pivot = Row::Load(A->row[best]);
    const double inverse = 1.0 / A->row[best][j];
    pivots[j] = __builtin_fabs(A->row[best][j]);
    if (best != j) Row::Load(A->row[j]).Store(A->row[best]);
    for (int i = j + 1; i < n; ++i) {
      Row row = Row::Load(A->row[i]);
      row.Add(-inverse * A->row[i][j], pivot);
      row.Store(A->row[i]);
    }
  }
}

// A row of which less than this is left is a sum of those before it (squared, relative).
constexpr double kRowLost = 1e-12;

template <int kWidth, int kColumns>
bool Basis(RowBasis* basis) noexcept {
  using Row = Lanes<kWidth, kColumns>;
  Row q[RowBasis::kMaxVectors];
  for (int i = 0; i < basis->rows; ++i) {
    Row x = Row::Load(basis->vector[i]);
    const double before = x.Dot(x);
    double* part = basis->part[i];
    for (int j = 0; j < i; ++j) part[j] = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
      double along[RowBasis::kMaxVectors];
      for (int j = 0; j < i; ++j) along[j] = x.Dot(q[j]);
      for (int j = 0; j < i; ++j) {
        x.Add(-along[j], q[j]);
        part[j] += along[j];
      }
    }
    const double left = x.Dot(x);
    if (!(left > kRowLost * before)) return false;
    part[i] = __builtin_sqrt(left);
    x.Scale(1.0 / part[i]);
    x.Store(basis->vector[i]);
    q[i] = x;
  }
  return true;
}

template <int kWidth>
bool BasisOfAny(RowBasis* basis) noexcept {
  return basis->columns <= 8 ? Basis<kWidth, 8>(basis) : Basis<kWidth, kMaxJoints>(basis);
}

template <int kWidth>
constexpr SingularKernels MakeSingularKernels() noexcept {
  return {SolveAny<kWidth>, DiagonalOfAny<kWidth>, NearAny<kWidth>, PivotsOfAny<kWidth>,
          BasisOfAny<kWidth>};
}

}  // namespace
}  // namespace vantage
