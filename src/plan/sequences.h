#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

namespace vantage::plan {

/// The best sequences of states, by dynamic programming.
class Sequences {
 public:
  /// @param value        N×S: of each state at each step; -inf: not allowed. @pre not empty.
  /// @param predecessor  For each state those that it may follow.
  /// @param may_follow  (step, from, to): whether a state may follow another, which is
  ///                     among its predecessors.
  template <class MayFollow>
  Sequences(const Eigen::MatrixXd& value, const std::vector<std::vector<int>>& predecessor,
            const MayFollow& may_follow)
      : sum_(value.row(0)) {
    const Eigen::Index N = value.rows(), S = value.cols();
    from_.assign(N, std::vector<int>(S, -1));
    for (Eigen::Index i = 1; i < N; ++i) {
      Eigen::VectorXd next = Eigen::VectorXd::Constant(S, kImpossible);
      for (Eigen::Index s = 0; s < S; ++s) {
        double best = kImpossible;
        for (const int p : predecessor[s]) {
          if (sum_(p) > best && may_follow(i, p, static_cast<int>(s))) {
            best = sum_(p);
            from_[i][s] = p;
          }
        }
        next(s) = best + value(i, s);
      }
      sum_ = next;
    }
  }

  /// The best of all, one state a step; empty: there is none.
  [[nodiscard]] std::vector<int> Best() const {
    Eigen::Index end = 0;
    if (!(sum_.maxCoeff(&end) > kImpossible)) return {};
    std::vector<int> sequence(from_.size());
    for (std::size_t i = from_.size(); i-- > 0;) {
      sequence[i] = static_cast<int>(end);
      end = from_[i][end];
    }
    return sequence;
  }

 private:
  static constexpr double kImpossible = -std::numeric_limits<double>::infinity();

  Eigen::VectorXd sum_;
  std::vector<std::vector<int>> from_;
};

}  // namespace vantage::plan
