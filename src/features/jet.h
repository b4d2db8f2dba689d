#pragma once

#include <cmath>

#include <Eigen/Core>

namespace vantage {

/// A value with its first and second derivatives by N variables.
template <int N>
struct Jet {
  double v{0.0};
  Eigen::Matrix<double, N, 1> g{Eigen::Matrix<double, N, 1>::Zero()};
  Eigen::Matrix<double, N, N> h{Eigen::Matrix<double, N, N>::Zero()};

  /// The variable number i.
  static Jet Variable(double value, int i) noexcept {
    Jet x;
    x.v = value;
    x.g(i) = 1.0;
    return x;
  }
};

/// f(x), from f and its derivatives at x.v.
template <int N>
[[nodiscard]] Jet<N> Chain(const Jet<N>& x, double f, double df, double ddf) noexcept {
  Jet<N> y;
  y.v = f;
  y.g = df * x.g;
  y.h = df * x.h + ddf * x.g * x.g.transpose();
  return y;
}

template <int N>
[[nodiscard]] Jet<N> operator+(const Jet<N>& a, const Jet<N>& b) noexcept {
  return {a.v + b.v, a.g + b.g, a.h + b.h};
}

template <int N>
[[nodiscard]] Jet<N> operator-(const Jet<N>& a, const Jet<N>& b) noexcept {
  return {a.v - b.v, a.g - b.g, a.h - b.h};
}

template <int N>
[[nodiscard]] Jet<N> operator*(double factor, const Jet<N>& a) noexcept {
  return {factor * a.v, factor * a.g, factor * a.h};
}

template <int N>
[[nodiscard]] Jet<N> operator*(const Jet<N>& a, const Jet<N>& b) noexcept {
  const Eigen::Matrix<double, N, N> cross = a.g * b.g.transpose();
  return {a.v * b.v, a.v * b.g + b.v * a.g, a.v * b.h + b.v * a.h + cross + cross.transpose()};
}

template <int N>
[[nodiscard]] Jet<N> Inverse(const Jet<N>& a) noexcept {
  const double i = 1.0 / a.v;
  return Chain(a, i, -i * i, 2.0 * i * i * i);
}

template <int N>
[[nodiscard]] Jet<N> Sqrt(const Jet<N>& a) noexcept {
  const double root = std::sqrt(a.v);
  return Chain(a, root, 0.5 / root, -0.25 / (root * a.v));
}

template <int N>
[[nodiscard]] Jet<N> Atan2(const Jet<N>& y, const Jet<N>& x) noexcept {
  const double r2 = x.v * x.v + y.v * y.v;
  const double fx = -y.v / r2;
  const double fy = x.v / r2;
  const double fxx = 2.0 * x.v * y.v / (r2 * r2);
  const double fxy = (y.v * y.v - x.v * x.v) / (r2 * r2);
  const Eigen::Matrix<double, N, N> cross = x.g * y.g.transpose();
  Jet<N> a;
  a.v = std::atan2(y.v, x.v);
  a.g = fx * x.g + fy * y.g;
  a.h = fx * x.h + fy * y.h + fxx * (x.g * x.g.transpose() - y.g * y.g.transpose()) +
        fxy * (cross + cross.transpose());
  return a;
}

}  // namespace vantage
