#include "vantage/control/bounded_least_squares.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <Eigen/Cholesky>

namespace vantage {
namespace {

enum class Place { kFree, kLower, kUpper };

struct ActiveSet {
  JointVector x;
  std::array<Place, kMaxJoints> place{};

  void Bind(int i, const JointVector& lower, const JointVector& upper) {
    // A box of no width binds at its lower side.
    place[i] = x(i) - lower(i) <= upper(i) - x(i) ? Place::kLower : Place::kUpper;
    x(i) = place[i] == Place::kLower ? lower(i) : upper(i);
  }
};

// Minimiser over the free components, the bound ones held.
JointVector SolveFree(const JointMatrix& H, const JointVector& g, const ActiveSet& set) {
  const int n = static_cast<int>(g.size());
  std::array<int, kMaxJoints> free{};
  int count = 0;
  for (int i = 0; i < n; ++i) {
    if (set.place[i] == Place::kFree) free[count++] = i;
  }
  JointVector z = set.x;
  if (count == 0) return z;
  JointMatrix H_free(count, count);
  JointVector g_free(count);
  for (int a = 0; a < count; ++a) {
    g_free(a) = g(free[a]);
    for (int j = 0; j < n; ++j) {
      if (set.place[j] != Place::kFree) g_free(a) -= H(free[a], j) * set.x(j);
    }
    for (int b = 0; b < count; ++b) H_free(a, b) = H(free[a], free[b]);
  }
  const Eigen::LLT<JointMatrix> factor(H_free);
  const JointVector z_free = factor.solve(g_free);
  for (int a = 0; a < count; ++a) z(free[a]) = z_free(a);
  return z;
}

// Moves x towards z until the first free component meets its bound; binds it. False: none did.
bool StepToBound(const JointVector& z, const JointVector& lower, const JointVector& upper,
                 ActiveSet* set) {
  double step = 1.0;
  int blocking = -1;
  for (int i = 0; i < z.size(); ++i) {
    if (set->place[i] != Place::kFree) continue;
    const double bound = z(i) < lower(i) ? lower(i) : (z(i) > upper(i) ? upper(i) : z(i));
    if (bound == z(i)) continue;
    const double fraction = (bound - set->x(i)) / (z(i) - set->x(i));
    if (fraction < step) {
      step = fraction;
      blocking = i;
    }
  }
  for (int i = 0; i < z.size(); ++i) {
    if (set->place[i] == Place::kFree) {
      const double moved = set->x(i) + step * (z(i) - set->x(i));
      set->x(i) = std::min(std::max(moved, lower(i)), upper(i));
    }
  }
  if (blocking < 0) return false;
  // The blocking component is set exactly on the bound it ran into.
  const bool low = z(blocking) < lower(blocking);
  set->place[blocking] = low ? Place::kLower : Place::kUpper;
  set->x(blocking) = low ? lower(blocking) : upper(blocking);
  return true;
}

// The bound component that would gain most by leaving its bound; -1: none.
int WorstViolation(const JointMatrix& H, const JointVector& g, const JointVector& lower,
                   const JointVector& upper, const ActiveSet& set) {
  const JointVector gradient = H * set.x - g;
  const double tolerance =
      1e-12 * (g.lpNorm<Eigen::Infinity>() + gradient.lpNorm<Eigen::Infinity>());
  double worst = tolerance;
  int index = -1;
  for (int i = 0; i < g.size(); ++i) {
    if (set.place[i] == Place::kFree || lower(i) == upper(i)) continue;
    const double gain = set.place[i] == Place::kLower ? -gradient(i) : gradient(i);
    if (gain > worst) {
      worst = gain;
      index = i;
    }
  }
  return index;
}

}  // namespace

BoxSolution MinimiseInBox(const JointMatrix& H, const JointVector& g, const JointVector& lower,
                          const JointVector& upper, const JointVector& start) noexcept {
  const int n = static_cast<int>(g.size());
  assert(H.rows() == n && H.cols() == n && lower.size() == n && upper.size() == n);
  ActiveSet set;
  set.x = start.cwiseMax(lower).cwiseMin(upper);
  for (int i = 0; i < n; ++i) {
    set.place[i] = Place::kFree;
    if (set.x(i) <= lower(i) || set.x(i) >= upper(i)) set.Bind(i, lower, upper);
  }

  BoxSolution solution;
  for (int round = 0; round < 3 * n + 10; ++round) {
    const JointVector z = SolveFree(H, g, set);
    if (!z.allFinite()) break;
    if (StepToBound(z, lower, upper, &set)) continue;
    const int release = WorstViolation(H, g, lower, upper, set);
    if (release < 0) {
      solution.optimal = true;
      break;
    }
    set.place[release] = Place::kFree;
  }
  solution.x = set.x;
  for (int i = 0; i < n; ++i) solution.active += set.place[i] == Place::kFree ? 0 : 1;
  return solution;
}

}  // namespace vantage
