#pragma once

#include "batch_kernels.h"
#include "batch_lanes.h"

/// @file
/// The kernels themselves, over any xsimd register. Each formula is written once and run in two ways: a
/// camera in every lane and one sample at a time (scans), or a sample in every lane and one camera
/// (profiles and gradients).

namespace vantage::batch {
namespace {

constexpr double kHuge = 1e30;  // Larger than any depth or margin, also in single precision.

// ---- Cameras ------------------------------------------------------------------------------------

template <class B>
struct Camera {
  Vec<B> r1, r2, r3;  // axes of C in the world
  Vec<B> c;           // centre
  B zoom;
};

template <class B, class T>
Camera<B> LoadCameras(const CamerasView<T>& cameras, int first) noexcept {
  const auto at = [&](int field) { return B::load_unaligned(cameras.field[field] + first); };
  return {{at(0), at(1), at(2)},
          {at(3), at(4), at(5)},
          {at(6), at(7), at(8)},
          {at(9), at(10), at(11)},
          at(kZoomField)};
}

template <class B, class T>
Camera<B> BroadcastCamera(const CamerasView<T>& cameras) noexcept {
  const auto at = [&](int field) { return B(cameras.field[field][0]); };
  return {{at(0), at(1), at(2)},
          {at(3), at(4), at(5)},
          {at(6), at(7), at(8)},
          {at(9), at(10), at(11)},
          at(kZoomField)};
}

// ---- Rows x1, y1, x2 ----------------------------------------------------------------------------
//
// With d_i = P_i - c, Z_i = r3 d_i, A_i the derivative of P_i by the joints and b = q × d2,
// q = r2 - (shear / aspect) r1:
//   row(x2) = zoom aspect / Z2² bᵀ A2,   row(x1) × row(y1) = zoom² aspect / Z1³ adj(A1) d1,
// so that for three joints det J_c = zoom³ aspect² / (Z1³ Z2²) b · M d1, M = A2 adj(A1). b is
// orthogonal to d2, so a multiple of d2 may be added to M d1: that frees M of its last entry.

template <class B>
struct TripleCamera {
  Vec<B> q, h, r3, c;  // h = q × c
  B z0;                // -r3 c
  B scale;
};

template <class B, class T>
TripleCamera<B> PrepareTriple(const Camera<B>& camera, const Lens<T>& lens) noexcept {
  const B ratio(lens.shear / lens.aspect);
  TripleCamera<B> t;
  t.q = {Fnma(ratio, camera.r1.x, camera.r2.x), Fnma(ratio, camera.r1.y, camera.r2.y),
         Fnma(ratio, camera.r1.z, camera.r2.z)};
  t.c = camera.c;
  t.h = Cross(t.q, t.c);
  t.r3 = camera.r3;
  t.z0 = -Dot(t.r3, t.c);
  t.scale = camera.zoom * camera.zoom * camera.zoom * B(lens.aspect * lens.aspect);
  return t;
}

// Fields of a record; M comes first.
enum TripleField { kTripleM0 = 8, kTripleP1 = 11, kTripleP2 = 14, kTripleTail = 17 };

template <class B>
struct TripleTerms {
  Vec<B> u, b;
  B numerator;  // b · u
  B Z1, Z2;
  B denominator;  // Z1³ Z2²
};

template <class B, class Record>
inline TripleTerms<B> Triple(const Record& s, const TripleCamera<B>& k) noexcept {
  TripleTerms<B> t;
  t.u.x = Fnma(s[0], k.c.x, Fnma(s[1], k.c.y, Fnma(s[2], k.c.z, s[kTripleM0])));
  t.u.y = Fnma(s[3], k.c.x, Fnma(s[4], k.c.y, Fnma(s[5], k.c.z, s[kTripleM0 + 1])));
  t.u.z = Fnma(s[6], k.c.x, Fnma(s[7], k.c.y, s[kTripleM0 + 2]));
  const Vec<B> P2 = s.Vector(kTripleP2);
  t.b.x = Fnma(k.q.z, P2.y, Fms(k.q.y, P2.z, k.h.x));
  t.b.y = Fnma(k.q.x, P2.z, Fms(k.q.z, P2.x, k.h.y));
  t.b.z = Fnma(k.q.y, P2.x, Fms(k.q.x, P2.y, k.h.z));
  t.numerator = Dot(t.u, t.b);
  t.Z1 = DotPlus(k.r3, s.Vector(kTripleP1), k.z0);
  t.Z2 = DotPlus(k.r3, P2, k.z0);
  const B Z12 = t.Z1 * t.Z2;
  t.denominator = Z12 * Z12 * t.Z1;
  return t;
}

// What more than three columns add: w² = (b·u)² + |m|² |τ|², m = adj(A1) d1, τ = tailᵀ b.
template <class B, class Record>
inline Vec<B> AdjugateTimesRay(const Record& s, int field, const Vec<B>& c) noexcept {
  return {Fnma(s[field], c.x, Fnma(s[field + 1], c.y, Fnma(s[field + 2], c.z, s[field + 9]))),
          Fnma(s[field + 3], c.x, Fnma(s[field + 4], c.y, Fnma(s[field + 5], c.z, s[field + 10]))),
          Fnma(s[field + 6], c.x, Fnma(s[field + 7], c.y, Fnma(s[field + 8], c.z, s[field + 11])))};
}

template <class B, class Record>
inline B TripleVolume(const Record& s, const TripleCamera<B>& k, const TripleTerms<B>& t,
                      int tail) noexcept {
  if (tail == 0) return xsimd::abs(t.numerator);
  const Vec<B> m = AdjugateTimesRay(s, kTripleTail, k.c);
  B tau2(0);
  for (int i = 0; i < tail; ++i) {
    const B tau = Dot(s.Vector(kTripleTail + 12 + 3 * i), t.b);
    tau2 = Fma(tau, tau, tau2);
  }
  return xsimd::sqrt(Fma(t.numerator, t.numerator, Dot(m, m) * tau2));
}

// w of one sample without the camera's scale; 0 where a point is behind.
template <class B, class Record>
inline B TripleW(const Record& s, const TripleCamera<B>& k, int tail, const B& min_depth) noexcept {
  const TripleTerms<B> t = Triple(s, k);
  const B w = TripleVolume(s, k, t, tail) / t.denominator;
  return xsimd::select(xsimd::min(t.Z1, t.Z2) > min_depth, w, B(0));
}

// ---- Rows x1, y1 --------------------------------------------------------------------------------
//
// w = zoom² aspect |adj(A1) d1| / Z1³.

enum PairField { kPairP = 0, kPairAdjugate = 3 };

template <class B, class Record>
inline B PairW(const Record& s, const TripleCamera<B>& k, const B& min_depth) noexcept {
  const Vec<B> m = AdjugateTimesRay(s, kPairAdjugate, k.c);
  const B Z = DotPlus(k.r3, s.Vector(kPairP), k.z0);
  const B w = xsimd::sqrt(Dot(m, m)) / (Z * Z * Z);
  return xsimd::select(Z > min_depth, w, B(0));
}

// ---- Points of one body, six columns or more ----------------------------------------------------
//
// w_c = w_r w_v, and w_v does not depend on the point about which the body's twist is taken. Take the
// first point: its rows then hold its translation alone. With r = P_i - P_1 in camera axes, v = 1/Z_i
// and (x1, y1) the image of P_1, the 2-vectors that point i adds to the columns are, besides
// (v, 0) and (0, v) of the first two:
//   T = v² (rx - x1 rz, ry - y1 rz)          translation along the axis, less its share at P_1
//   A = (ry gx, ry gy + v rz)                turn about x (sign left out), g = v (x1, y1) + T
//   B = (rx gx + v rz, rx gy)                turn about y
//   C = (v ry, -v rx)                        turn about z (sign left out)
// The first two columns are eliminated exactly: w_v = zoom⁶ aspect N sqrt(det H), N = Σ v²,
// H = G - S Sᵀ / N, G the Gram matrix of T, A, B, C and S their products with v. What is kept below is
// N H, and K, what is left of it when T is eliminated too, times its first entry.

template <class B>
struct SixCamera {
  Vec<B> r1, r2, r3;
  Vec<B> t;  // -R c
  B scale;
  B aspect, shear;
};

template <class B, class T>
SixCamera<B> PrepareSix(const Camera<B>& camera, const Lens<T>& lens) noexcept {
  SixCamera<B> s;
  s.r1 = camera.r1;
  s.r2 = camera.r2;
  s.r3 = camera.r3;
  s.t = {-Dot(camera.r1, camera.c), -Dot(camera.r2, camera.c), -Dot(camera.r3, camera.c)};
  const B zoom3 = camera.zoom * camera.zoom * camera.zoom;
  s.scale = zoom3 * zoom3 * B(lens.aspect);
  s.aspect = B(lens.aspect);
  s.shear = B(lens.shear);
  return s;
}

enum SixField { kSixP1 = 0, kSixR = 3 };  // w_r comes last

template <class B, int P>
struct SixPoints {  // after the projection
  Vec<B> r[P - 1];
  B v[P];
  B x1, y1;
  B nearest;  // least depth
};

template <int P, class B, class Record>
inline void ProjectSix(const Record& s, const SixCamera<B>& k, SixPoints<B, P>* out) noexcept {
  const Vec<B> P1 = s.Vector(kSixP1);
  const B X1 = DotPlus(k.r1, P1, k.t.x);
  const B Y1 = DotPlus(k.r2, P1, k.t.y);
  B Z[P];
  Z[0] = DotPlus(k.r3, P1, k.t.z);
#pragma GCC unroll 8
  for (int i = 1; i < P; ++i) {
    const Vec<B> r = s.Vector(kSixR + 3 * (i - 1));
    out->r[i - 1] = {Dot(k.r1, r), Dot(k.r2, r), Dot(k.r3, r)};
    Z[i] = Z[0] + out->r[i - 1].z;
  }
  // One division for all the depths: partial products up, inverses down. Pairs shorten the chain.
  B pair[(P + 1) / 2];
  B nearest = Z[0];
#pragma GCC unroll 8
  for (int i = 0; i < P / 2; ++i) {
    pair[i] = Z[2 * i] * Z[2 * i + 1];
    nearest = xsimd::min(nearest, xsimd::min(Z[2 * i], Z[2 * i + 1]));
  }
  if (P % 2 == 1) {
    pair[P / 2] = Z[P - 1];
    nearest = xsimd::min(nearest, Z[P - 1]);
  }
  constexpr int kPairs = (P + 1) / 2;
  B product[kPairs];
  product[0] = pair[0];
#pragma GCC unroll 4
  for (int i = 1; i < kPairs; ++i) product[i] = product[i - 1] * pair[i];
  B inverse = B(1) / product[kPairs - 1];
#pragma GCC unroll 4
  for (int i = kPairs - 1; i >= 0; --i) {
    const B of_pair = i > 0 ? inverse * product[i > 0 ? i - 1 : 0] : inverse;
    if (i > 0) inverse = inverse * pair[i];
    if (2 * i + 1 < P) {
      out->v[2 * i] = of_pair * Z[2 * i + 1];
      out->v[2 * i + 1] = of_pair * Z[2 * i];
    } else {
      out->v[2 * i] = of_pair;
    }
  }
  out->x1 = X1 * out->v[0];
  out->y1 = Y1 * out->v[0];
  out->nearest = nearest;
}

template <class B>
struct SixColumns {  // what one point adds to the four columns
  B Tx, Ty, Ax, Ay, Bx, By, Cx, Cy;
};

template <bool kSquare, class B>
inline SixColumns<B> ColumnsOf(const Vec<B>& r, const B& v, const B& v2, const B& x1, const B& y1,
                               const SixCamera<B>& k) noexcept {
  SixColumns<B> f;
  f.Tx = Fnma(x1, r.z, r.x) * v2;
  f.Ty = Fnma(y1, r.z, r.y) * v2;
  const B gx = Fma(v, x1, f.Tx);
  const B gy = Fma(v, y1, f.Ty);
  const B vz = v * r.z;
  f.Ax = r.y * gx;
  f.Ay = Fma(r.y, gy, vz);
  f.Bx = Fma(r.x, gx, vz);
  f.By = r.x * gy;
  f.Cx = v * r.y;
  f.Cy = -(v * r.x);
  if (!kSquare) {
    f.Tx = Fma(k.aspect, f.Tx, k.shear * f.Ty);
    f.Ax = Fma(k.aspect, f.Ax, k.shear * f.Ay);
    f.Bx = Fma(k.aspect, f.Bx, k.shear * f.By);
    f.Cx = Fma(k.aspect, f.Cx, k.shear * f.Cy);
  }
  return f;
}

template <class B>
struct SixGram {  // N H, upper triangle, order T, A, B, C
  B h00, h01, h02, h03, h11, h12, h13, h22, h23, h33;
  B N;
  B Stx, Sty, Sax, Say, Sbx, Sby, Scx, Scy;
};

template <int P, bool kSquare, class B>
inline SixGram<B> GramSix(const SixPoints<B, P>& q, const SixCamera<B>& k) noexcept {
  SixGram<B> g;
  g.N = q.v[0] * q.v[0];
  B g00, g01, g02, g03, g11, g12, g13, g22, g23, g33;
#pragma GCC unroll 8
  for (int i = 1; i < P; ++i) {
    const B v = q.v[i];
    const B v2 = v * v;
    const SixColumns<B> f = ColumnsOf<kSquare>(q.r[i - 1], v, v2, q.x1, q.y1, k);
    g.N = g.N + v2;
    if (i == 1) {
      g.Stx = v * f.Tx;
      g.Sty = v * f.Ty;
      g.Sax = v * f.Ax;
      g.Say = v * f.Ay;
      g.Sbx = v * f.Bx;
      g.Sby = v * f.By;
      g.Scx = v * f.Cx;
      g.Scy = v * f.Cy;
      g00 = Fma(f.Tx, f.Tx, f.Ty * f.Ty);
      g01 = Fma(f.Tx, f.Ax, f.Ty * f.Ay);
      g02 = Fma(f.Tx, f.Bx, f.Ty * f.By);
      g03 = Fma(f.Tx, f.Cx, f.Ty * f.Cy);
      g11 = Fma(f.Ax, f.Ax, f.Ay * f.Ay);
      g12 = Fma(f.Ax, f.Bx, f.Ay * f.By);
      g13 = Fma(f.Ax, f.Cx, f.Ay * f.Cy);
      g22 = Fma(f.Bx, f.Bx, f.By * f.By);
      g23 = Fma(f.Bx, f.Cx, f.By * f.Cy);
      g33 = Fma(f.Cx, f.Cx, f.Cy * f.Cy);
    } else {
      g.Stx = Fma(v, f.Tx, g.Stx);
      g.Sty = Fma(v, f.Ty, g.Sty);
      g.Sax = Fma(v, f.Ax, g.Sax);
      g.Say = Fma(v, f.Ay, g.Say);
      g.Sbx = Fma(v, f.Bx, g.Sbx);
      g.Sby = Fma(v, f.By, g.Sby);
      g.Scx = Fma(v, f.Cx, g.Scx);
      g.Scy = Fma(v, f.Cy, g.Scy);
      g00 = Fma(f.Tx, f.Tx, Fma(f.Ty, f.Ty, g00));
      g01 = Fma(f.Tx, f.Ax, Fma(f.Ty, f.Ay, g01));
      g02 = Fma(f.Tx, f.Bx, Fma(f.Ty, f.By, g02));
      g03 = Fma(f.Tx, f.Cx, Fma(f.Ty, f.Cy, g03));
      g11 = Fma(f.Ax, f.Ax, Fma(f.Ay, f.Ay, g11));
      g12 = Fma(f.Ax, f.Bx, Fma(f.Ay, f.By, g12));
      g13 = Fma(f.Ax, f.Cx, Fma(f.Ay, f.Cy, g13));
      g22 = Fma(f.Bx, f.Bx, Fma(f.By, f.By, g22));
      g23 = Fma(f.Bx, f.Cx, Fma(f.By, f.Cy, g23));
      g33 = Fma(f.Cx, f.Cx, Fma(f.Cy, f.Cy, g33));
    }
  }
  g.h00 = Fnma(g.Stx, g.Stx, Fnma(g.Sty, g.Sty, g.N * g00));
  g.h01 = Fnma(g.Stx, g.Sax, Fnma(g.Sty, g.Say, g.N * g01));
  g.h02 = Fnma(g.Stx, g.Sbx, Fnma(g.Sty, g.Sby, g.N * g02));
  g.h03 = Fnma(g.Stx, g.Scx, Fnma(g.Sty, g.Scy, g.N * g03));
  g.h11 = Fnma(g.Sax, g.Sax, Fnma(g.Say, g.Say, g.N * g11));
  g.h12 = Fnma(g.Sax, g.Sbx, Fnma(g.Say, g.Sby, g.N * g12));
  g.h13 = Fnma(g.Sax, g.Scx, Fnma(g.Say, g.Scy, g.N * g13));
  g.h22 = Fnma(g.Sbx, g.Sbx, Fnma(g.Sby, g.Sby, g.N * g22));
  g.h23 = Fnma(g.Sbx, g.Scx, Fnma(g.Sby, g.Scy, g.N * g23));
  g.h33 = Fnma(g.Scx, g.Scx, Fnma(g.Scy, g.Scy, g.N * g33));
  return g;
}

// N sqrt(det H). With K = h00 h_ij - h0i h0j: det(N H) = det K / h00², det H = det(N H) / N⁴.
template <class B>
inline B VolumeOf(const SixGram<B>& g) noexcept {
  const B k11 = Fnma(g.h01, g.h01, g.h00 * g.h11);
  const B k12 = Fnma(g.h01, g.h02, g.h00 * g.h12);
  const B k13 = Fnma(g.h01, g.h03, g.h00 * g.h13);
  const B k22 = Fnma(g.h02, g.h02, g.h00 * g.h22);
  const B k23 = Fnma(g.h02, g.h03, g.h00 * g.h23);
  const B k33 = Fnma(g.h03, g.h03, g.h00 * g.h33);
  const B c1 = Fnma(k23, k23, k22 * k33);
  const B c2 = Fnma(k12, k33, k13 * k23);
  const B c3 = Fnma(k13, k22, k12 * k23);
  const B det = Fma(k11, c1, Fma(k12, c2, k13 * c3));
  return xsimd::sqrt(xsimd::max(det, B(0))) / (g.h00 * g.N);
}

// ---- Any rows and columns -----------------------------------------------------------------------

// J without zoom: `count` vectors of `length` entries, columns or rows, whichever are fewer.
template <class B>
struct Vectors {
  B at[kMaxBatchRows * kMaxBatchColumns];
  int count, length;
  B& operator()(int vector, int entry) noexcept { return at[vector * length + entry]; }
};

template <class B, class T, class Record>
B FillGeneric(const SceneView<T>& scene, const Record& s, const Camera<B>& camera,
              const Lens<T>& lens, Vectors<B>* J) noexcept {
  const int n = scene.columns;
  const bool tall = scene.rows >= n;
  J->count = tall ? n : scene.rows;
  J->length = tall ? scene.rows : n;
  B nearest = All<B>(kHuge);
  int loaded = -1;
  Vec<B> d{}, gx{}, gy{};
  for (int k = 0; k < scene.rows; ++k) {
    const Row row = scene.row[k];
    const int base = row.point * (3 + 3 * n);
    if (row.point != loaded) {
      loaded = row.point;
      d = s.Vector(base) - camera.c;
      const B Z = Dot(camera.r3, d);
      nearest = xsimd::min(nearest, Z);
      const B v = B(1) / Z;
      const B x = Dot(camera.r1, d) * v;
      const B y = Dot(camera.r2, d) * v;
      const auto over_depth = [&](const B& a, const B& r3) { return Fnma(a, r3, B(0)) * v; };
      const Vec<B> ix{Fma(camera.r1.x, v, over_depth(x, camera.r3.x)),
                      Fma(camera.r1.y, v, over_depth(x, camera.r3.y)),
                      Fma(camera.r1.z, v, over_depth(x, camera.r3.z))};
      gy = {Fma(camera.r2.x, v, over_depth(y, camera.r3.x)),
            Fma(camera.r2.y, v, over_depth(y, camera.r3.y)),
            Fma(camera.r2.z, v, over_depth(y, camera.r3.z))};
      const B aspect(lens.aspect), shear(lens.shear);
      gx = {Fma(aspect, ix.x, shear * gy.x), Fma(aspect, ix.y, shear * gy.y),
            Fma(aspect, ix.z, shear * gy.z)};
    }
    const Vec<B> g = row.axis == 0 ? gx : gy;
    for (int j = 0; j < n; ++j) {
      const B entry =
          Fma(g.x, s[base + 3 + j], Fma(g.y, s[base + 3 + n + j], g.z * s[base + 3 + 2 * n + j]));
      (tall ? (*J)(j, k) : (*J)(k, j)) = entry;
    }
  }
  return nearest;
}

// Volume of the parallelepiped that the vectors span, by modified Gram-Schmidt: its error grows with
// the condition number, not with its square.
template <class B>
B VolumeOf(Vectors<B>* J) noexcept {
  const B tiny = All<B>(1e-30);
  B volume(1);
  for (int i = 0; i < J->count; ++i) {
    B norm2(0);
    for (int e = 0; e < J->length; ++e) norm2 = Fma((*J)(i, e), (*J)(i, e), norm2);
    volume = volume * xsimd::sqrt(norm2);
    const B inverse = B(1) / xsimd::max(norm2, tiny);
    for (int j = i + 1; j < J->count; ++j) {
      B dot(0);
      for (int e = 0; e < J->length; ++e) dot = Fma((*J)(i, e), (*J)(j, e), dot);
      dot = dot * inverse;
      for (int e = 0; e < J->length; ++e) (*J)(j, e) = Fnma(dot, (*J)(i, e), (*J)(j, e));
    }
  }
  return volume;
}

// One-sided Jacobi rotations until the vectors are orthogonal in every lane; then their squared lengths
// are the squared singular values.
template <class B>
void Orthogonalise(Vectors<B>* J, B* sigma2) noexcept {
  using T = typename B::value_type;
  const B epsilon =
      All<B>(sizeof(T) == 8 ? 1e-30 : 1e-13);  // squared cosine that counts as orthogonal
  const B tiny = All<B>(1e-35);
  constexpr int kSweeps = 30;  // five to eight are used
  bool rotated = true;
  for (int sweep = 0; sweep < kSweeps && rotated; ++sweep) {
    rotated = false;
    for (int i = 0; i < J->count; ++i) {
      for (int j = i + 1; j < J->count; ++j) {
        B a(0), b(0), g(0);
        for (int e = 0; e < J->length; ++e) {
          a = Fma((*J)(i, e), (*J)(i, e), a);
          b = Fma((*J)(j, e), (*J)(j, e), b);
          g = Fma((*J)(i, e), (*J)(j, e), g);
        }
        const auto skew = g * g > Fma(epsilon * a, b, tiny);
        if (!xsimd::any(skew)) continue;
        rotated = true;
        const B safe = xsimd::select(skew, g, B(1));
        const B zeta = (b - a) / (safe + safe);
        const B size = B(1) / (xsimd::abs(zeta) + xsimd::sqrt(Fma(zeta, zeta, B(1))));
        const B t = xsimd::select(zeta < B(0), -size, size);
        const B cosine = B(1) / xsimd::sqrt(Fma(t, t, B(1)));
        const B c = xsimd::select(skew, cosine, B(1));
        const B s = xsimd::select(skew, cosine * t, B(0));
        for (int e = 0; e < J->length; ++e) {
          const B x = (*J)(i, e);
          const B y = (*J)(j, e);
          (*J)(i, e) = Fnma(s, y, c * x);
          (*J)(j, e) = Fma(s, x, c * y);
        }
      }
    }
  }
  for (int i = 0; i < J->count; ++i) {
    sigma2[i] = B(0);
    for (int e = 0; e < J->length; ++e) sigma2[i] = Fma((*J)(i, e), (*J)(i, e), sigma2[i]);
  }
}

template <class B>
B SpectralQuantity(Quantity quantity, const B* sigma2, int count, const B& zoom) noexcept {
  B least = sigma2[0], greatest = sigma2[0];
  for (int i = 1; i < count; ++i) {
    least = xsimd::min(least, sigma2[i]);
    greatest = xsimd::max(greatest, sigma2[i]);
  }
  if (quantity == Quantity::kSigmaMin) return zoom * xsimd::sqrt(least);
  if (quantity == Quantity::kInverseCondition) {
    return xsimd::select(greatest > B(0), xsimd::sqrt(least / greatest), B(0));
  }
  B trace(0);
  for (int i = 0; i < count; ++i) trace = trace + B(1) / sigma2[i];
  return -trace / (zoom * zoom);
}

template <class B>
B PowerOf(const B& base, int exponent) noexcept {
  B result(1);
  for (int i = 0; i < exponent; ++i) result = result * base;
  return result;
}

// ---- Scans: a camera in each lane ---------------------------------------------------------------

// Quantities that may be -inf.
constexpr bool IsUnbounded(Quantity quantity) noexcept {
  return quantity == Quantity::kLogW || quantity == Quantity::kNegativeTrace;
}

// Value that a sample has when a point is behind the camera.
template <class B>
B WorstOf(Quantity quantity) noexcept {
  return All<B>(IsUnbounded(quantity) ? -__builtin_huge_val() : 0.0);
}

template <class B>
class Tally {
 public:
  using T = typename B::value_type;
  explicit Tally(Quantity quantity) noexcept
      : log_(quantity == Quantity::kLogW),
        unbounded_(IsUnbounded(quantity)),
        worst_(WorstOf<B>(quantity)) {}
  // `w` of one sample as the quantity asks, before the logarithm.
  void Add(const B& w, const B& weight) noexcept {
    B value = w;
    if (log_) value = xsimd::select(w > B(0), xsimd::log(w), worst_);
    // 0 · -inf is no number; samples without weight count for the least value alone.
    sum_ = unbounded_ ? sum_ + xsimd::select(weight > B(0), weight * value, B(0))
                      : Fma(weight, value, sum_);
    least_ = xsimd::min(least_, value);
  }
  void Store(const ValueOutput<T>& out, int first) const noexcept {
    sum_.store_unaligned(out.sum + first);
    if (out.least != nullptr) least_.store_unaligned(out.least + first);
  }

 private:
  bool log_;
  bool unbounded_;
  B worst_;
  B sum_ = All<B>(0.0);
  B least_ = All<B>(__builtin_huge_val());
};

// Least depth of all points, or a little less.
template <class B, class T>
B LeastDepthBound(const HullView<T>& hull, const Vec<B>& r3, const B& z0) noexcept {
  B nearest = All<B>(kHuge);
  const T* p = hull.node;
  for (int i = 0; i < hull.nodes; ++i, p += 3) {
    nearest = xsimd::min(nearest, DotPlus(r3, Vec<B>{B(p[0]), B(p[1]), B(p[2])}, z0));
  }
  return nearest - B(hull.sag);
}

// Σ weight w of three rows and three columns for cameras that no point is behind: two samples share a
// division.
template <class B, class T>
B SumTriple(const SceneView<T>& scene, const TripleCamera<B>& k) noexcept {
  B sum(0);
  const T* record = scene.weighted;
  const int pairs = scene.samples / 2;
  for (int i = 0; i < pairs; ++i, record += 2 * kTripleTail) {
    const TripleTerms<B> a = Triple(Broadcast<B>(record), k);
    const TripleTerms<B> b = Triple(Broadcast<B>(record + kTripleTail), k);
    sum =
        sum + Fma(xsimd::abs(a.numerator), b.denominator, xsimd::abs(b.numerator) * a.denominator) /
                  (a.denominator * b.denominator);
  }
  if (scene.samples % 2 == 1) {
    const TripleTerms<B> a = Triple(Broadcast<B>(record), k);
    sum = sum + xsimd::abs(a.numerator) / a.denominator;
  }
  return sum * k.scale;
}

template <class B, class T>
void ScanTriple(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                Quantity quantity, const ValueOutput<T>& out) noexcept {
  const int tail = scene.columns - 3;
  const B min_depth(scene.min_depth);
  for (int first = 0; first < cameras.count; first += static_cast<int>(B::size)) {
    const TripleCamera<B> k = PrepareTriple(LoadCameras<B>(cameras, first), lens);
    B sum(0);
    typename B::batch_bool_type known(false);
    if (out.least == nullptr && quantity == Quantity::kW && scene.weighted != nullptr) {
      known = LeastDepthBound(scene.hull, k.r3, k.z0) > min_depth;
      if (xsimd::any(known)) sum = SumTriple(scene, k);
      if (xsimd::all(known)) {
        sum.store_unaligned(out.sum + first);
        continue;
      }
    }
    Tally<B> tally(quantity);
    for (int i = 0; i < scene.samples; ++i) {
      const Broadcast<B> s(scene.record + static_cast<long>(i) * scene.fields);
      tally.Add(k.scale * TripleW(s, k, tail, min_depth), B(scene.weight[i]));
    }
    tally.Store(out, first);
    if (xsimd::any(known)) {
      // A camera's sum must not depend on its neighbours' in the last digit.
      xsimd::select(known, sum, B::load_unaligned(out.sum + first))
          .store_unaligned(out.sum + first);
    }
  }
}

template <class B, class T>
void ScanPair(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
              Quantity quantity, const ValueOutput<T>& out) noexcept {
  const B min_depth(scene.min_depth);
  for (int first = 0; first < cameras.count; first += static_cast<int>(B::size)) {
    const Camera<B> camera = LoadCameras<B>(cameras, first);
    const TripleCamera<B> k = PrepareTriple(camera, lens);
    const B scale = camera.zoom * camera.zoom * B(lens.aspect);
    Tally<B> tally(quantity);
    for (int i = 0; i < scene.samples; ++i) {
      const Broadcast<B> s(scene.record + static_cast<long>(i) * scene.fields);
      tally.Add(scale * PairW(s, k, min_depth), B(scene.weight[i]));
    }
    tally.Store(out, first);
  }
}

// Three stages of three neighbouring samples are in work at once: the chain of one sample is long, and
// stages of different samples do not wait for each other.
template <int P, bool kSquare, class B, class T>
void ScanSix(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
             Quantity quantity, const ValueOutput<T>& out) noexcept {
  const B min_depth(scene.min_depth);
  const int last = scene.samples - 1;
  const int w_r = scene.fields - 1;
  const auto record = [&](int i) {
    return scene.record + static_cast<long>(i < last ? i : last) * scene.fields;
  };
  for (int first = 0; first < cameras.count; first += static_cast<int>(B::size)) {
    const SixCamera<B> k = PrepareSix(LoadCameras<B>(cameras, first), lens);
    Tally<B> tally(quantity);
    SixPoints<B, P> points;
    ProjectSix<P>(Broadcast<B>(record(0)), k, &points);
    SixGram<B> gram = GramSix<P, kSquare>(points, k);
    B nearest = points.nearest;
    ProjectSix<P>(Broadcast<B>(record(1)), k, &points);
    for (int i = 0; i <= last; ++i) {
      const B volume = VolumeOf(gram);
      const B w = xsimd::select(nearest > min_depth, k.scale * B(record(i)[w_r]) * volume, B(0));
      gram = GramSix<P, kSquare>(points, k);
      nearest = points.nearest;
      ProjectSix<P>(Broadcast<B>(record(i + 2)), k, &points);
      tally.Add(w, B(scene.weight[i]));
    }
    tally.Store(out, first);
  }
}

template <bool kSquare, class B, class T>
void ScanSixBySize(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                   Quantity quantity, const ValueOutput<T>& out) noexcept {
  switch (scene.points) {
    case 3:
      return ScanSix<3, kSquare, B>(scene, cameras, lens, quantity, out);
    case 4:
      return ScanSix<4, kSquare, B>(scene, cameras, lens, quantity, out);
    case 5:
      return ScanSix<5, kSquare, B>(scene, cameras, lens, quantity, out);
    case 6:
      return ScanSix<6, kSquare, B>(scene, cameras, lens, quantity, out);
    case 7:
      return ScanSix<7, kSquare, B>(scene, cameras, lens, quantity, out);
    default:
      return ScanSix<8, kSquare, B>(scene, cameras, lens, quantity, out);
  }
}

template <class B, class T, class Record>
B GenericW(const SceneView<T>& scene, const Record& s, const Camera<B>& camera, const Lens<T>& lens,
           Quantity quantity) noexcept {
  Vectors<B> J;
  const B nearest = FillGeneric(scene, s, camera, lens, &J);
  B value;
  if (quantity == Quantity::kW || quantity == Quantity::kLogW) {
    value = PowerOf(camera.zoom, J.count) * VolumeOf(&J);
  } else {
    B sigma2[kMaxBatchColumns]{};
    Orthogonalise(&J, sigma2);
    value = SpectralQuantity(quantity, sigma2, J.count, camera.zoom);
  }
  const B worst = quantity == Quantity::kLogW ? B(0) : WorstOf<B>(quantity);
  return xsimd::select(nearest > B(scene.min_depth), value, worst);
}

template <class B, class T>
void ScanGeneric(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                 Quantity quantity, const ValueOutput<T>& out) noexcept {
  for (int first = 0; first < cameras.count; first += static_cast<int>(B::size)) {
    const Camera<B> camera = LoadCameras<B>(cameras, first);
    Tally<B> tally(quantity);
    for (int i = 0; i < scene.samples; ++i) {
      const Broadcast<B> s(scene.record + static_cast<long>(i) * scene.fields);
      tally.Add(GenericW(scene, s, camera, lens, quantity), B(scene.weight[i]));
    }
    tally.Store(out, first);
  }
}

template <class B, class T>
void ScanValues(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                Quantity quantity, const ValueOutput<T>& out) {
  switch (scene.family) {
    case Family::kTriple:
      return ScanTriple<B>(scene, cameras, lens, quantity, out);
    case Family::kPair:
      return ScanPair<B>(scene, cameras, lens, quantity, out);
    case Family::kRigidSix:
      if (lens.aspect == T(1) && lens.shear == T(0)) {
        return ScanSixBySize<true, B>(scene, cameras, lens, quantity, out);
      }
      return ScanSixBySize<false, B>(scene, cameras, lens, quantity, out);
    case Family::kGeneric:
      return ScanGeneric<B>(scene, cameras, lens, quantity, out);
  }
}

// ---- Constraints --------------------------------------------------------------------------------

template <class B, class T>
void ScanFrustum(const HullView<T>& hull, const CamerasView<T>& cameras, const Lens<T>& lens,
                 const FrustumOutput<T>& out) {
  for (int first = 0; first < cameras.count; first += static_cast<int>(B::size)) {
    const Camera<B> k = LoadCameras<B>(cameras, first);
    // The image is the square |x'| <= Z, |y'| <= Z of these axes.
    const B x_scale = k.zoom * B(T(1) / lens.x_half), y_scale = k.zoom * B(T(1) / lens.y_half);
    const B x_shift = B(lens.x_mid / lens.x_half), y_shift = B(lens.y_mid / lens.y_half);
    const auto axis = [&](const Vec<B>& r, const B& scale, const B& shift) {
      return Vec<B>{Fnma(shift, k.r3.x, scale * r.x), Fnma(shift, k.r3.y, scale * r.y),
                    Fnma(shift, k.r3.z, scale * r.z)};
    };
    const Vec<B> ax = axis(k.r1, x_scale, x_shift);
    const Vec<B> ay = axis(k.r2, y_scale, y_shift);
    const B x0 = -Dot(ax, k.c), y0 = -Dot(ay, k.c), z0 = -Dot(k.r3, k.c);
    B nearest = All<B>(kHuge), farthest = All<B>(-kHuge), inside = All<B>(kHuge);
    struct Place {
      B depth, margin;
    };
    const auto place = [&](const T* p) {
      const Vec<B> P{B(p[0]), B(p[1]), B(p[2])};
      const B Z = DotPlus(k.r3, P, z0);
      return Place{Z, Z - LargerSize(DotPlus(ax, P, x0), DotPlus(ay, P, y0))};
    };
    const auto visit = [&](const Place& at) {
      nearest = xsimd::min(nearest, at.depth);
      farthest = xsimd::max(farthest, at.depth);
      inside = xsimd::min(inside, at.margin);
    };
    for (int i = 0; i < hull.nodes; ++i) visit(place(hull.node + 3 * i));

    // Depth changes by 1 a metre, the image's margin by the longest normal of its four sides. Where these
    // bounds keep a limit, they are the answer.
    const auto side = [&](const Vec<B>& a) {
      const Vec<B> plus = Plus(k.r3, a), minus = k.r3 - a;
      return xsimd::max(Dot(plus, plus), Dot(minus, minus));
    };
    const B steepness = xsimd::sqrt(xsimd::max(side(ax), side(ay)));
    const B near_limit(hull.min_depth), far_limit(hull.max_depth), sag(hull.sag);
    const B near_bound = nearest - sag, far_bound = farthest + sag;
    const B image_bound = Fnma(steepness, sag, inside);
    const auto is_near = near_bound <= near_limit, is_far = far_bound >= far_limit;
    const B image_limit(hull.least_image);
    const auto is_out = image_bound <= image_limit;
    if (xsimd::any(is_near || is_far || is_out)) {
      // Elsewhere, the points of every chain that may hold the worst.
      Place from = place(hull.node);
      for (int i = 0; i + 1 < hull.nodes; ++i) {
        const Place to = place(hull.node + 3 * (i + 1));
        const Chain<T>& chain = hull.chain[i];
        const B room(chain.sag);
        const auto may_matter =
            (is_near && (xsimd::min(from.depth, to.depth) - room < nearest)) ||
            (is_far && (xsimd::max(from.depth, to.depth) + room > farthest)) ||
            (is_out && (Fnma(steepness, room, xsimd::min(from.margin, to.margin)) < inside));
        if (xsimd::any(may_matter)) {
          const T* p = hull.xyz + 3 * chain.first;
          for (int j = 0; j < chain.count; ++j) visit(place(p + 3 * j));
        }
        from = to;
      }
    }
    // A camera's margins must not depend on its neighbours, whose points were visited too.
    (xsimd::select(is_near, nearest, near_bound) - near_limit).store_unaligned(out.near + first);
    (far_limit - xsimd::select(is_far, farthest, far_bound)).store_unaligned(out.far + first);
    (xsimd::select(is_out, inside, image_bound) - image_limit).store_unaligned(out.image + first);
  }
}

// Distance from the segment P..P + v to a capsule's skin, as (distance² - r²) / 2r: exact in sign, and in
// size near 0. The nearest points of the two axes by one exact step: along the ray for the infinite axis,
// then along the axis within its ends, then along the ray again.
template <class B, class T>
inline B CapsuleGap(const CapsuleTest<T>& capsule, const Vec<B>& v, const B& v2,
                    const B& v2_inverse) noexcept {
  const Vec<B> u{B(capsule.u[0]), B(capsule.u[1]), B(capsule.u[2])};
  const Vec<B> e{B(capsule.e[0]), B(capsule.e[1]), B(capsule.e[2])};
  const B along = Dot(u, v);
  const B across = Dot(e, v);
  const B rest = xsimd::max(Fnma(along, along, v2), All<B>(sizeof(T) == 8 ? 1e-14 : 1e-7));
  const B s0 = Clamp(-across * RoughInverse(rest), B(0), B(1));
  const B t = Clamp(along * s0, B(capsule.before), B(capsule.after));
  const B s = Clamp(Fms(t, along, across) * v2_inverse, B(0), B(1));
  const B axial = Fms(s, along, t);
  const B distance2 = Fma(axial, axial, Fma(s, Fma(s, rest, across + across), B(capsule.e2)));
  return Fms(distance2, B(capsule.half_inverse), B(capsule.half_radius));
}

// Separation of the segment from `p` to `c` (both in the box's frame) and the box: the largest over the
// axes that can separate them. Negative when they meet.
template <class B, class T>
inline B BoxGap(const BoxTest<T>& box, const Vec<B>& p, const Vec<B>& c) noexcept {
  const B half = All<B>(0.5);
  const Vec<B> m{half * (p.x + c.x), half * (p.y + c.y), half * (p.z + c.z)};
  const Vec<B> d{half * (c.x - p.x), half * (c.y - p.y), half * (c.z - p.z)};
  const Vec<B> a{xsimd::abs(d.x), xsimd::abs(d.y), xsimd::abs(d.z)};
  const B ex(box.half[0]), ey(box.half[1]), ez(box.half[2]);
  const B gap = xsimd::max(xsimd::abs(m.x) - (ex + a.x),
                           xsimd::max(xsimd::abs(m.y) - (ey + a.y), xsimd::abs(m.z) - (ez + a.z)));
  const Vec<B> n = Cross(m, d);
  const B inverse = B(1) / xsimd::max(xsimd::sqrt(Dot(d, d)), All<B>(1e-6));
  const B cross = xsimd::max(xsimd::abs(n.x) - Fma(ey, a.z, ez * a.y),
                             xsimd::max(xsimd::abs(n.y) - Fma(ex, a.z, ez * a.x),
                                        xsimd::abs(n.z) - Fma(ex, a.y, ey * a.x)));
  return xsimd::max(gap, cross * inverse);
}

template <class B, class T>
void ScanObstacles(const ObstaclesView<T>& scene, const CamerasView<T>& cameras,
                   const ObstacleOutput<T>& out) {
  for (int first = 0; first < cameras.count; first += static_cast<int>(B::size)) {
    const Camera<B> k = LoadCameras<B>(cameras, first);
    Vec<B> in_box[kMaxBatchBoxes];
    const auto to_box = [](const BoxTest<T>& box, const Vec<B>& p) {
      const Vec<B> d{p.x - B(box.centre[0]), p.y - B(box.centre[1]), p.z - B(box.centre[2])};
      const auto row = [&](int i) {
        return Vec<B>{B(box.b[3 * i]), B(box.b[3 * i + 1]), B(box.b[3 * i + 2])};
      };
      return Vec<B>{Dot(row(0), d), Dot(row(1), d), Dot(row(2), d)};
    };
    for (int b = 0; b < scene.boxes; ++b) in_box[b] = to_box(scene.box[b], k.c);
    B clear = All<B>(kHuge), faces = All<B>(kHuge);
    for (int i = 0; i < scene.sights; ++i) {
      const Sight<T>& sight = scene.sight[i];
      const Vec<B> P{B(sight.p[0]), B(sight.p[1]), B(sight.p[2])};
      const Vec<B> v = k.c - P;
      const B v2 = Dot(v, v);
      if (scene.facing) {
        const Vec<B> normal{B(sight.normal[0]), B(sight.normal[1]), B(sight.normal[2])};
        faces = xsimd::min(faces, Fnma(B(scene.min_cosine), xsimd::sqrt(v2), Dot(normal, v)));
      }
      if (sight.capsules > 0) {
        const B v2_inverse = B(1) / v2;
        const CapsuleTest<T>* capsule = scene.capsule + sight.first_capsule;
        for (int j = 0; j < sight.capsules; ++j) {
          clear = xsimd::min(clear, CapsuleGap(capsule[j], v, v2, v2_inverse));
        }
      }
      for (int b = 0; b < scene.boxes; ++b) {
        clear = xsimd::min(clear, BoxGap(scene.box[b], to_box(scene.box[b], P), in_box[b]));
      }
    }
    clear.store_unaligned(out.occlusion + first);
    faces.store_unaligned(out.facing + first);
  }
}

// ---- Profiles: a sample in each lane, with the derivatives by the camera's twist ----------------
//
// The twist is (v, ω) in camera axes: the camera moves by v and turns by ω about its own axes, so a
// point p in camera axes moves by -(v + ω × p).

template <class B>
struct TwistGradient {
  Vec<B> v, omega;
};

template <class B, class T>
void StoreGradient(const TwistGradient<B>& g, const SceneView<T>& scene, int first,
                   T* gradient) noexcept {
  const B* value[6] = {&g.v.x, &g.v.y, &g.v.z, &g.omega.x, &g.omega.y, &g.omega.z};
  for (int i = 0; i < 6; ++i) {
    value[i]->store_unaligned(gradient + static_cast<long>(i) * scene.padded + first);
  }
}

template <class B>
Vec<B> Scaled(const B& a, const Vec<B>& b) noexcept {
  return {a * b.x, a * b.y, a * b.z};
}
template <class B>
Vec<B> Plus(const Vec<B>& a, const Vec<B>& b) noexcept {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

// Adds `slope` times the derivative of the depth of the point d (in the world, from the centre).
template <class B>
void AddDepth(const Camera<B>& k, const Vec<B>& d, const B& slope, TwistGradient<B>* g) noexcept {
  g->v.z = g->v.z - slope;
  g->omega.x = Fnma(slope, Dot(k.r2, d), g->omega.x);
  g->omega.y = Fma(slope, Dot(k.r1, d), g->omega.y);
}

template <class B, class T>
void ProfileTriple(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                   const ProfileOutput<T>& out) noexcept {
  const Camera<B> camera = BroadcastCamera<B>(cameras);
  const TripleCamera<B> k = PrepareTriple(camera, lens);
  const B ratio(lens.shear / lens.aspect);
  const B min_depth(scene.min_depth);
  const int tail = scene.columns - 3;
  for (int first = 0; first < scene.padded; first += static_cast<int>(B::size)) {
    const Gathered<B> s(scene.lanes, scene.padded, first);
    const TripleTerms<B> t = Triple(s, k);
    const auto seen = xsimd::min(t.Z1, t.Z2) > min_depth;
    const B over = xsimd::select(seen, k.scale / t.denominator, B(0));
    const B volume = TripleVolume(s, k, t, tail);
    const B w = over * volume;
    w.store_unaligned(out.w + first);
    if (out.gradient == nullptr) continue;

    const Vec<B> d1 = s.Vector(kTripleP1) - k.c;
    const Vec<B> d2 = s.Vector(kTripleP2) - k.c;
    // d volume = sign · (b·du + u·db) plus the share of the tail; by_b, by_c gather what multiplies db
    // and dc, with db = dq × d2 - q × dc.
    const bool square = tail == 0;
    const B per_volume = B(1) / xsimd::max(volume, All<B>(1e-35));
    const B head =
        square ? xsimd::select(t.numerator < B(0), B(-1), B(1)) : t.numerator * per_volume;
    Vec<B> by_b = Scaled(head, t.u);
    const Vec<B>& b = t.b;
    const Vec<B> Mt_b{Fma(s[0], b.x, Fma(s[3], b.y, s[6] * b.z)),
                      Fma(s[1], b.x, Fma(s[4], b.y, s[7] * b.z)), Fma(s[2], b.x, s[5] * b.y)};
    Vec<B> by_c = Scaled(-head, Mt_b);
    if (!square) {
      const Vec<B> m = AdjugateTimesRay(s, kTripleTail, k.c);
      const B m2 = Dot(m, m);
      B tau2(0);
      for (int i = 0; i < tail; ++i) {
        const Vec<B> column = s.Vector(kTripleTail + 12 + 3 * i);
        const B tau = Dot(column, b);
        tau2 = Fma(tau, tau, tau2);
        by_b = Plus(by_b, Scaled(m2 * tau * per_volume, column));
      }
      const auto a = [&](int i) { return s[kTripleTail + i]; };
      const Vec<B> At_m{Fma(a(0), m.x, Fma(a(3), m.y, a(6) * m.z)),
                        Fma(a(1), m.x, Fma(a(4), m.y, a(7) * m.z)),
                        Fma(a(2), m.x, Fma(a(5), m.y, a(8) * m.z))};
      by_c = Plus(by_c, Scaled(-tau2 * per_volume, At_m));
    }
    const Vec<B> by_q = Cross(d2, by_b);
    by_c = by_c - Cross(by_b, k.q);
    // dq of q = r2 - ratio r1, and dc, by the twist.
    TwistGradient<B> g;
    g.v = {Dot(camera.r1, by_c), Dot(camera.r2, by_c), Dot(camera.r3, by_c)};
    const B q1 = Dot(camera.r1, by_q), q2 = Dot(camera.r2, by_q), q3 = Dot(camera.r3, by_q);
    g.omega = {q3, ratio * q3, -Fma(ratio, q2, q1)};
    g.v = Scaled(over, g.v);
    g.omega = Scaled(over, g.omega);
    AddDepth(camera, d1, xsimd::select(seen, B(-3) * w / t.Z1, B(0)), &g);
    AddDepth(camera, d2, xsimd::select(seen, B(-2) * w / t.Z2, B(0)), &g);
    StoreGradient(g, scene, first, out.gradient);
  }
}

template <class B, class T>
void ProfilePair(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                 const ProfileOutput<T>& out) noexcept {
  const Camera<B> camera = BroadcastCamera<B>(cameras);
  const B scale = camera.zoom * camera.zoom * B(lens.aspect);
  const B min_depth(scene.min_depth);
  for (int first = 0; first < scene.padded; first += static_cast<int>(B::size)) {
    const Gathered<B> s(scene.lanes, scene.padded, first);
    const Vec<B> m = AdjugateTimesRay(s, kPairAdjugate, camera.c);
    const Vec<B> d = s.Vector(kPairP) - camera.c;
    const B Z = Dot(camera.r3, d);
    const auto seen = Z > min_depth;
    const B over = xsimd::select(seen, scale / (Z * Z * Z), B(0));
    const B length = xsimd::sqrt(Dot(m, m));
    const B w = over * length;
    w.store_unaligned(out.w + first);
    if (out.gradient == nullptr) continue;
    const B per_length = over / xsimd::max(length, All<B>(1e-35));
    const auto a = [&](int i) { return s[kPairAdjugate + i]; };
    const Vec<B> by_c = Scaled(-per_length, Vec<B>{Fma(a(0), m.x, Fma(a(3), m.y, a(6) * m.z)),
                                                   Fma(a(1), m.x, Fma(a(4), m.y, a(7) * m.z)),
                                                   Fma(a(2), m.x, Fma(a(5), m.y, a(8) * m.z))});
    TwistGradient<B> g;
    g.v = {Dot(camera.r1, by_c), Dot(camera.r2, by_c), Dot(camera.r3, by_c)};
    g.omega = {B(0), B(0), B(0)};
    AddDepth(camera, d, xsimd::select(seen, B(-3) * w / Z, B(0)), &g);
    StoreGradient(g, scene, first, out.gradient);
  }
}

// Inverse of a symmetric, positive definite 4×4 matrix by L D Lᵀ.
template <class B>
void InvertFour(const B (&h)[4][4], B (&x)[4][4]) noexcept {
  B L[4][4], d[4];
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j <= i; ++j) {
      B sum = h[i][j];
      for (int k = 0; k < j; ++k) sum = Fnma(L[i][k] * d[k], L[j][k], sum);
      if (i == j) {
        d[i] = sum;
      } else {
        L[i][j] = sum / d[j];
      }
    }
  }
  // X = L^-T D^-1 L^-1, with U = L^-1.
  B U[4][4];
  for (int i = 0; i < 4; ++i) {
    U[i][i] = B(1);
    for (int j = 0; j < i; ++j) {
      B sum(0);
      for (int k = j; k < i; ++k) sum = Fnma(L[i][k], U[k][j], sum);
      U[i][j] = sum;
    }
  }
  for (int i = 0; i < 4; ++i) {
    for (int j = i; j < 4; ++j) {
      B sum(0);
      for (int k = j; k < 4; ++k) sum = sum + U[k][i] * U[k][j] / d[k];
      x[i][j] = sum;
      x[j][i] = sum;
    }
  }
}

template <int P, class B, class T>
void ProfileSix(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                const ProfileOutput<T>& out) noexcept {
  const Camera<B> camera = BroadcastCamera<B>(cameras);
  const SixCamera<B> k = PrepareSix(camera, lens);
  const B min_depth(scene.min_depth);
  for (int first = 0; first < scene.padded; first += static_cast<int>(B::size)) {
    const Gathered<B> s(scene.lanes, scene.padded, first);
    SixPoints<B, P> q;
    ProjectSix<P>(s, k, &q);
    const SixGram<B> g = GramSix<P, false>(q, k);
    const auto seen = q.nearest > min_depth;
    const B w = xsimd::select(seen, k.scale * s[scene.fields - 1] * VolumeOf(g), B(0));
    w.store_unaligned(out.w + first);
    if (out.gradient == nullptr) continue;

    // log w = log N + log(det H) / 2. Its derivative by the columns is H^-1 times what is left of them;
    // by the inverse depths, what the elimination takes away.
    const B N1 = B(1) / g.N;
    const B gram[4][4] = {{g.h00, g.h01, g.h02, g.h03},
                          {g.h01, g.h11, g.h12, g.h13},
                          {g.h02, g.h12, g.h22, g.h23},
                          {g.h03, g.h13, g.h23, g.h33}};
    B X[4][4];
    InvertFour(gram, X);  // (N H)^-1
    for (auto& row : X) {
      for (B& entry : row) entry = entry * g.N;
    }
    const B mx[4] = {g.Stx * N1, g.Sax * N1, g.Sbx * N1, g.Scx * N1};
    const B my[4] = {g.Sty * N1, g.Say * N1, g.Sby * N1, g.Scy * N1};
    B by_x1(0), by_y1(0), by_Z1(0);
    TwistGradient<B> twist;
    twist.omega = {B(0), B(0), B(0)};
    // Derivative by v of point i, which the elimination of the first two columns has.
    const auto by_mean = [&](const B& v, const B(&lx)[4], const B(&ly)[4]) {
      B sum = (v + v) * N1;
      for (int b = 0; b < 4; ++b) sum = Fnma(lx[b], mx[b], Fnma(ly[b], my[b], sum));
      return sum;
    };
    const auto times_inverse = [&](const B(&ax)[4], const B(&ay)[4], B(&lx)[4], B(&ly)[4]) {
      for (int b = 0; b < 4; ++b) {
        lx[b] = B(0);
        ly[b] = B(0);
        for (int a = 0; a < 4; ++a) {
          lx[b] = Fma(X[a][b], ax[a], lx[b]);
          ly[b] = Fma(X[a][b], ay[a], ly[b]);
        }
      }
    };
    for (int i = 1; i < P; ++i) {
      const Vec<B>& r = q.r[i - 1];
      const B v = q.v[i];
      const B v2 = v * v;
      const SixColumns<B> f = ColumnsOf<false>(r, v, v2, q.x1, q.y1, k);
      const B ax[4] = {Fnma(v, mx[0], f.Tx), Fnma(v, mx[1], f.Ax), Fnma(v, mx[2], f.Bx),
                       Fnma(v, mx[3], f.Cx)};
      const B ay[4] = {Fnma(v, my[0], f.Ty), Fnma(v, my[1], f.Ay), Fnma(v, my[2], f.By),
                       Fnma(v, my[3], f.Cy)};
      B lx[4], ly[4];
      times_inverse(ax, ay, lx, ly);
      B by_v = by_mean(v, lx, ly);
      // Back through the lens: columns were (aspect fx + shear fy, fy).
      for (int b = 0; b < 4; ++b) {
        ly[b] = Fma(k.shear, lx[b], ly[b]);
        lx[b] = k.aspect * lx[b];
      }
      const B Tx = Fnma(q.x1, r.z, r.x);
      const B Ty = Fnma(q.y1, r.z, r.y);
      const B gx = Fma(v2, Tx, v * q.x1);
      const B gy = Fma(v2, Ty, v * q.y1);
      Vec<B> by_r;
      by_r.y = Fma(lx[1], gx, Fma(ly[1], gy, lx[3] * v));
      by_r.x = Fma(lx[2], gx, Fnma(ly[3], v, ly[2] * gy));
      const B by_gx = Fma(lx[1], r.y, lx[2] * r.x);
      const B by_gy = Fma(ly[1], r.y, ly[2] * r.x);
      const B by_vz = ly[1] + lx[2];
      by_v =
          by_v + Fma(lx[3], r.y, Fnma(ly[3], r.x, Fma(by_vz, r.z, Fma(by_gx, q.x1, by_gy * q.y1))));
      by_r.z = by_vz * v;
      by_x1 = Fma(by_gx, v, by_x1);
      by_y1 = Fma(by_gy, v, by_y1);
      const B by_Tx = lx[0] + by_gx;
      const B by_Ty = ly[0] + by_gy;
      by_r.x = Fma(by_Tx, v2, by_r.x);
      by_r.y = Fma(by_Ty, v2, by_r.y);
      by_r.z = Fnma(v2, Fma(by_Tx, q.x1, by_Ty * q.y1), by_r.z);
      by_x1 = Fnma(by_Tx * v2, r.z, by_x1);
      by_y1 = Fnma(by_Ty * v2, r.z, by_y1);
      by_v = Fma(v + v, Fma(by_Tx, Tx, by_Ty * Ty), by_v);
      const B by_Z = -by_v * v2;
      by_r.z = by_r.z + by_Z;
      by_Z1 = by_Z1 + by_Z;
      twist.omega = twist.omega - Cross(r, by_r);
    }
    // The first point: its own columns are 0.
    {
      const B v = q.v[0];
      const B ax[4] = {-v * mx[0], -v * mx[1], -v * mx[2], -v * mx[3]};
      const B ay[4] = {-v * my[0], -v * my[1], -v * my[2], -v * my[3]};
      B lx[4], ly[4];
      times_inverse(ax, ay, lx, ly);
      const Vec<B> P1 = s.Vector(kSixP1) - camera.c;
      const Vec<B> p{Dot(k.r1, P1), Dot(k.r2, P1), Dot(k.r3, P1)};
      const B by_v = by_mean(v, lx, ly) + Fma(by_x1, p.x, by_y1 * p.y);
      const Vec<B> by_p{by_x1 * v, by_y1 * v, Fnma(by_v, v * v, by_Z1)};
      twist.omega = twist.omega - Cross(p, by_p);
      twist.v = {-by_p.x, -by_p.y, -by_p.z};
    }
    // Where w vanishes the derivative of its logarithm is not finite.
    const auto moves = w > B(0);
    const auto times_w = [&](const B& a) { return xsimd::select(moves, w * a, B(0)); };
    const TwistGradient<B> result{
        {times_w(twist.v.x), times_w(twist.v.y), times_w(twist.v.z)},
        {times_w(twist.omega.x), times_w(twist.omega.y), times_w(twist.omega.z)}};
    StoreGradient(result, scene, first, out.gradient);
  }
}

// Values alone.
template <class B, class T>
void ProfileGeneric(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
                    const ProfileOutput<T>& out) noexcept {
  const Camera<B> camera = BroadcastCamera<B>(cameras);
  for (int first = 0; first < scene.padded; first += static_cast<int>(B::size)) {
    const Gathered<B> s(scene.lanes, scene.padded, first);
    GenericW(scene, s, camera, lens, Quantity::kW).store_unaligned(out.w + first);
  }
}

template <class B, class T>
void Profile(const SceneView<T>& scene, const CamerasView<T>& cameras, const Lens<T>& lens,
             const ProfileOutput<T>& out) {
  switch (scene.family) {
    case Family::kTriple:
      return ProfileTriple<B>(scene, cameras, lens, out);
    case Family::kPair:
      return ProfilePair<B>(scene, cameras, lens, out);
    case Family::kRigidSix:
      switch (scene.points) {
        case 3:
          return ProfileSix<3, B>(scene, cameras, lens, out);
        case 4:
          return ProfileSix<4, B>(scene, cameras, lens, out);
        case 5:
          return ProfileSix<5, B>(scene, cameras, lens, out);
        case 6:
          return ProfileSix<6, B>(scene, cameras, lens, out);
        case 7:
          return ProfileSix<7, B>(scene, cameras, lens, out);
        default:
          return ProfileSix<8, B>(scene, cameras, lens, out);
      }
    case Family::kGeneric:
      return ProfileGeneric<B>(scene, cameras, lens, out);
  }
}

// ---- Table --------------------------------------------------------------------------------------

template <class B>
constexpr Kernels<typename B::value_type> MakeKernels() noexcept {
  using T = typename B::value_type;
  return {static_cast<int>(B::size), &ScanValues<B, T>, &ScanFrustum<B, T>, &ScanObstacles<B, T>,
          &Profile<B, T>};
}

template <class Arch>
constexpr KernelTable MakeTable() noexcept {
  return {MakeKernels<xsimd::batch<double, Arch>>(), MakeKernels<xsimd::batch<float, Arch>>()};
}

}  // namespace
}  // namespace vantage::batch
