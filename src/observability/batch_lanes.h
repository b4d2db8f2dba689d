#pragma once

#include <xsimd/xsimd.hpp>

/// @file
/// The few operations on SIMD registers that the batch kernels are written in. Included once in each
/// translation unit that is compiled for one instruction set; everything has internal linkage.

namespace vantage::batch {
namespace {

// Fused where the machine has it; where not, the compiler may still contract.
template <class B>
inline B Fma(const B& a, const B& b, const B& c) noexcept {  // a b + c
  return xsimd::fma(a, b, c);
}
template <class B>
inline B Fnma(const B& a, const B& b, const B& c) noexcept {  // c - a b
  return c - a * b;
}
template <class B>
inline B Fms(const B& a, const B& b, const B& c) noexcept {  // a b - c
  return a * b - c;
}
// The larger of |a| and |b|.
template <class B>
inline B LargerSize(const B& a, const B& b) noexcept {
  return xsimd::max(xsimd::abs(a), xsimd::abs(b));
}
// 1/a to half the digits of the type or better; a is neither 0 nor denormal.
template <class B>
inline B RoughInverse(const B& a) noexcept {
  return B(1) / a;
}

#ifdef __AVX512DQ__
using D512 = xsimd::batch<double, xsimd::avx512f>;
using F512 = xsimd::batch<float, xsimd::avx512f>;
inline D512 Fma(const D512& a, const D512& b, const D512& c) noexcept {
  return _mm512_fmadd_pd(a, b, c);
}
inline F512 Fma(const F512& a, const F512& b, const F512& c) noexcept {
  return _mm512_fmadd_ps(a, b, c);
}
inline D512 Fnma(const D512& a, const D512& b, const D512& c) noexcept {
  return _mm512_fnmadd_pd(a, b, c);
}
inline F512 Fnma(const F512& a, const F512& b, const F512& c) noexcept {
  return _mm512_fnmadd_ps(a, b, c);
}
inline D512 Fms(const D512& a, const D512& b, const D512& c) noexcept {
  return _mm512_fmsub_pd(a, b, c);
}
inline F512 Fms(const F512& a, const F512& b, const F512& c) noexcept {
  return _mm512_fmsub_ps(a, b, c);
}
// Greater of the two magnitudes, sign cleared: one instruction for three.
inline D512 LargerSize(const D512& a, const D512& b) noexcept {
  return _mm512_range_pd(a, b, 0b1011);
}
inline F512 LargerSize(const F512& a, const F512& b) noexcept {
  return _mm512_range_ps(a, b, 0b1011);
}
inline D512 RoughInverse(const D512& a) noexcept {
  const D512 x = _mm512_rcp14_pd(a);
  return Fma(x, Fnma(a, x, D512(1.0)), x);
}
inline F512 RoughInverse(const F512& a) noexcept {
  return _mm512_rcp14_ps(a);
}
#elif defined(__AVX2__)
using D256 = xsimd::batch<double, xsimd::fma3<xsimd::avx2> >;
using F256 = xsimd::batch<float, xsimd::fma3<xsimd::avx2> >;
inline D256 Fnma(const D256& a, const D256& b, const D256& c) noexcept {
  return _mm256_fnmadd_pd(a, b, c);
}
inline F256 Fnma(const F256& a, const F256& b, const F256& c) noexcept {
  return _mm256_fnmadd_ps(a, b, c);
}
inline D256 Fms(const D256& a, const D256& b, const D256& c) noexcept {
  return _mm256_fmsub_pd(a, b, c);
}
inline F256 Fms(const F256& a, const F256& b, const F256& c) noexcept {
  return _mm256_fmsub_ps(a, b, c);
}
#endif

// The same value in every lane.
template <class B>
inline B All(double value) noexcept {
  return B(static_cast<typename B::value_type>(value));
}

template <class B>
inline B Clamp(const B& x, const B& low, const B& high) noexcept {
  return xsimd::min(xsimd::max(x, low), high);
}

// Three coordinates of a lane each.
template <class B>
struct Vec {
  B x, y, z;
};
template <class B>
inline B Dot(const Vec<B>& a, const Vec<B>& b) noexcept {
  return Fma(a.x, b.x, Fma(a.y, b.y, a.z * b.z));
}
template <class B>
inline B DotPlus(const Vec<B>& a, const Vec<B>& b, const B& c) noexcept {
  return Fma(a.x, b.x, Fma(a.y, b.y, Fma(a.z, b.z, c)));
}
template <class B>
inline Vec<B> Cross(const Vec<B>& a, const Vec<B>& b) noexcept {
  return {Fms(a.y, b.z, a.z * b.y), Fms(a.z, b.x, a.x * b.z), Fms(a.x, b.y, a.y * b.x)};
}
template <class B>
inline Vec<B> operator-(const Vec<B>& a, const Vec<B>& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

// A record read as one value in every lane.
template <class B>
class Broadcast {
 public:
  using T = typename B::value_type;
  explicit Broadcast(const T* record) noexcept : record_(record) {}
  B operator[](int field) const noexcept { return B(record_[field]); }
  Vec<B> Vector(int field) const noexcept {
    return {(*this)[field], (*this)[field + 1], (*this)[field + 2]};
  }

 private:
  const T* record_;
};

// Records of consecutive samples, one in each lane.
template <class B>
class Gathered {
 public:
  using T = typename B::value_type;
  Gathered(const T* lanes, int padded, int first) noexcept
      : first_(lanes + first), padded_(padded) {}
  B operator[](int field) const noexcept {
    return B::load_unaligned(first_ + static_cast<long>(field) * padded_);
  }
  Vec<B> Vector(int field) const noexcept {
    return {(*this)[field], (*this)[field + 1], (*this)[field + 2]};
  }

 private:
  const T* first_;
  long padded_;
};

}  // namespace
}  // namespace vantage::batch
