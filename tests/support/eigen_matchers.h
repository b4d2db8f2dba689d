#pragma once

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace vantage::test {

/// Same size, and no entry further apart than `tolerance` (a NaN is never near).
template <typename A, typename B>
::testing::AssertionResult Near(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b,
                                double tolerance) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) {
    return ::testing::AssertionFailure()
           << "sizes " << a.rows() << "x" << a.cols() << " and " << b.rows() << "x" << b.cols();
  }
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.cols(); ++j) {
      const double difference = std::abs(a(i, j) - b(i, j));
      if (!(difference <= tolerance)) {
        return ::testing::AssertionFailure()
               << "entry (" << i << ", " << j << "): " << a(i, j) << " and " << b(i, j)
               << " differ by " << difference << " > " << tolerance << "\n"
               << a << "\n--\n"
               << b;
      }
    }
  }
  return ::testing::AssertionSuccess();
}

}  // namespace vantage::test
