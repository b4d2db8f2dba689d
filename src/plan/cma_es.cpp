#include "cma_es.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace vantage::plan {

CmaEs::CmaEs(const SearchVector& start, double step, int lambda, std::uint64_t seed)
    : random_(seed), mean_(start), sigma_(step) {
  assert(lambda >= 4);
  const auto n = static_cast<double>(start.size());
  const int mu = lambda / 2;
  double sum = 0.0, sum2 = 0.0;
  for (int i = 0; i < mu; ++i) {
    weight_.push_back(std::log(0.5 * (lambda + 1)) - std::log(i + 1.0));
    sum += weight_.back();
  }
  for (double& w : weight_) {
    w /= sum;
    sum2 += w * w;
  }
  mu_eff_ = 1.0 / sum2;
  c_sigma_ = (mu_eff_ + 2.0) / (n + mu_eff_ + 5.0);
  d_sigma_ = 1.0 + 2.0 * std::max(0.0, std::sqrt((mu_eff_ - 1.0) / (n + 1.0)) - 1.0) + c_sigma_;
  c_c_ = (4.0 + mu_eff_ / n) / (n + 4.0 + 2.0 * mu_eff_ / n);
  c_1_ = 2.0 / ((n + 1.3) * (n + 1.3) + mu_eff_);
  c_mu_ = std::min(1.0 - c_1_,
                   2.0 * (mu_eff_ - 2.0 + 1.0 / mu_eff_) / ((n + 2.0) * (n + 2.0) + mu_eff_));
  chi_ = std::sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
  C_ = SearchMatrix::Identity(start.size(), start.size());
  basis_ = C_;
  root_ = SearchVector::Ones(start.size());
  path_sigma_ = path_c_ = SearchVector::Zero(start.size());
  members_.resize(lambda, start);
}

const std::vector<SearchVector>& CmaEs::Ask() {
  SearchVector z(mean_.size());
  for (SearchVector& member : members_) {
    for (Eigen::Index i = 0; i < z.size(); ++i) z(i) = normal_(random_);
    member = mean_ + sigma_ * (basis_ * root_.cwiseProduct(z));
  }
  return members_;
}

void CmaEs::Tell(const std::vector<int>& order) {
  const SearchVector old = mean_;
  mean_.setZero();
  for (int i = 0; i < mu(); ++i) mean_ += weight_[i] * members_[order[i]];
  const SearchVector step = (mean_ - old) / sigma_;
  const SearchVector white = basis_ * (basis_.transpose() * step).cwiseQuotient(root_);
  path_sigma_ =
      (1.0 - c_sigma_) * path_sigma_ + std::sqrt(c_sigma_ * (2.0 - c_sigma_) * mu_eff_) * white;
  ++generation_;
  const double length = path_sigma_.norm();
  const double faded = std::sqrt(1.0 - std::pow(1.0 - c_sigma_, 2.0 * generation_));
  const bool steady =
      length / faded < (1.4 + 2.0 / (static_cast<double>(mean_.size()) + 1.0)) * chi_;
  path_c_ *= 1.0 - c_c_;
  if (steady) path_c_ += std::sqrt(c_c_ * (2.0 - c_c_) * mu_eff_) * step;
  C_ *= 1.0 - c_1_ - c_mu_ + (steady ? 0.0 : c_1_ * c_c_ * (2.0 - c_c_));
  C_ += c_1_ * path_c_ * path_c_.transpose();
  for (int i = 0; i < mu(); ++i) {
    const SearchVector y = (members_[order[i]] - old) / sigma_;
    C_ += (c_mu_ * weight_[i]) * y * y.transpose();
  }
  sigma_ *= std::exp(std::min(1.0, c_sigma_ / d_sigma_ * (length / chi_ - 1.0)));
  Decompose();
}

void CmaEs::Decompose() {
  const Eigen::SelfAdjointEigenSolver<SearchMatrix> eigen(C_);
  basis_ = eigen.eigenvectors();
  root_ = eigen.eigenvalues().cwiseMax(1e-24).cwiseSqrt();
}

}  // namespace vantage::plan
