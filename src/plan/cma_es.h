#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "search_space.h"

namespace vantage::plan {

/// Evolution strategy with covariance matrix adaptation, (mu/mu_w, lambda), asked for a generation and told
/// how good its members were. Small populations of many searches are meant to be evaluated together.
///
/// @see N. Hansen, "The CMA Evolution Strategy: A Tutorial", arXiv:1604.00772, 2016.
class CmaEs {
 public:
  /// @param start   Where the search begins.
  /// @param step    Standard deviation there; > 0.
  /// @param lambda  Members of a generation; >= 4.
  /// @param seed    Of its random numbers.
  CmaEs(const SearchVector& start, double step, int lambda, std::uint64_t seed);

  /// The next generation.
  [[nodiscard]] const std::vector<SearchVector>& Ask();
  /// @param order  Members of the generation, best first; mu() of them are looked at.
  void Tell(const std::vector<int>& order);

  [[nodiscard]] int mu() const noexcept { return static_cast<int>(weight_.size()); }
  /// Largest standard deviation along any direction.
  [[nodiscard]] double reach() const noexcept { return sigma_ * root_.maxCoeff(); }

 private:
  using SearchMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                     kMaxRigAxes, kMaxRigAxes>;
  void Decompose();

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<double> weight_;
  double mu_eff_{1.0}, c_sigma_{0.0}, d_sigma_{1.0}, c_c_{0.0}, c_1_{0.0}, c_mu_{0.0}, chi_{1.0};
  SearchVector mean_;
  double sigma_;
  SearchMatrix C_, basis_;
  SearchVector root_;  // square roots of C's eigenvalues
  SearchVector path_sigma_, path_c_;
  int generation_{0};
  std::vector<SearchVector> members_;
};

}  // namespace vantage::plan
