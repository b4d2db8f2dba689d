#pragma once

#include <Eigen/Core>

namespace vantage::test {

/// Central differences of f at zero: column j is (f(h·e_j) - f(-h·e_j)) / 2h.
///
/// @param f     Callable from a perturbation vector (cols rows) to a vector value (rows rows).
/// @param h     Step. The default balances truncation (h²) and rounding (1e-16/h) for values near 1,
///   which leaves an error near 1e-10.
template <typename F>
Eigen::MatrixXd CentralDifference(F&& f, int rows, int cols, double h = 1e-5) {
  Eigen::MatrixXd J(rows, cols);
  for (int j = 0; j < cols; ++j) {
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(cols, j);
    const Eigen::VectorXd ahead = f(step);
    const Eigen::VectorXd behind = f(Eigen::VectorXd(-step));
    J.col(j) = (ahead - behind) / (2.0 * h);
  }
  return J;
}

}  // namespace vantage::test
