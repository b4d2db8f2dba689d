#include "polish.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <nlopt.hpp>

#include "vantage/math/spatial.h"

namespace vantage::plan {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using RowVector = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxRigAxes>;
using SearchJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxRigAxes>;

constexpr double kNear = 0.2;        // limits within this share of the unit are looked at
constexpr double kNearSight = 0.06;  // the same of sights, which cost more to look at
constexpr double kTrust = 0.08;      // one round moves at most this share of an axis' range
constexpr int kRounds = 10;
// Of one program: to see which hills are worth more, to choose between these, and to the end.
constexpr Tolerance kCoarse{1e-2, 1e-3};
constexpr Tolerance kRough{1e-6, 1e-9};
constexpr Tolerance kFine{1e-13, 1e-15};
constexpr double kStep = 1e-6;       // of differences along an axis, as a share of its range
constexpr double kPlaceStep = 1e-6;  // of differences by the camera's place, per unit
// Limits are kept by this much more than needed [per unit]: what rounding takes.
constexpr double kReserve = 1e-11;

// A half space that a point must keep in: a · p_C + b >= 0.
struct HalfSpace {
  PlanLimit limit;
  Vector3d a;
  double b;
};

std::array<HalfSpace, 6> FrustumOf(const PlacementModel& model) {
  const BatchLens& lens = model.problem().lens;
  const DepthLimits& depth = model.depth();
  const double x = -0.5 * (lens.x_max - lens.x_min) * model.rim_margin();
  const double y = -0.5 * (lens.y_max - lens.y_min) * model.rim_margin();
  return {{{PlanLimit::kNear, {0, 0, 1}, -depth.min},
           {PlanLimit::kFar, {0, 0, -1}, depth.max},
           {PlanLimit::kImage, {1, 0, -lens.x_min}, x},
           {PlanLimit::kImage, {-1, 0, lens.x_max}, x},
           {PlanLimit::kImage, {0, 1, -lens.y_min}, y},
           {PlanLimit::kImage, {0, -1, lens.y_max}, y}}};
}

// One inequality of the program: value >= 0.
struct Element {
  enum class Kind { kHalfSpace, kHidden, kFacing, kKeepOut, kSample };
  Kind kind;
  int index;      // half space, keep-out box
  int sample;     // kHalfSpace, kHidden, kFacing, kSample
  int point;      // kHalfSpace
  int offset;     // kHalfSpace
  double margin;  // where it was chosen

  [[nodiscard]] bool Same(const Element& other) const {
    return kind == other.kind && index == other.index && sample == other.sample &&
           point == other.point && offset == other.offset;
  }
};

class Program {
 public:
  Program(const PlacementModel& model, const SearchSpace& space, CameraScorer* scorer)
      : model_(model),
        space_(space),
        scorer_(scorer),
        frustum_(FrustumOf(model)),
        worst_sample_(model.problem().objective.aggregate == PlanAggregate::kWorst &&
                      model.offsets().size() == 1) {}

  /// Merit and margins at u.
  struct Judged {
    double merit{0.0};
    PlanMargins margins{};
    bool keeps{false};
    double violation{0.0};
  };
  Judged Judge(const SearchVector& u) {
    scorer_->Load({RigPose(space_.rig(), space_.ToRig(u))});
    std::vector<PlanMargins> margins;
    scorer_->Frustum(BatchPrecision::kDouble, &margins);
    scorer_->Obstacles(BatchPrecision::kDouble, &margins);
    std::vector<double> scores;
    scorer_->Scores(BatchPrecision::kDouble, &scores);
    return {model_.Merit(scores[0]), margins[0], model_.Keeps(margins[0]),
            model_.Violation(margins[0])};
  }

  /// Adds the limits, and for a worst case the samples, that are near at u.
  void Choose(const SearchVector& u, const PlanMargins& margins) {
    ChooseHalfSpaces(u);
    const double near = kNearSight * model_.unit();
    if (margins[IndexOf(PlanLimit::kHidden)] < near || margins[IndexOf(PlanLimit::kFacing)] < near)
      ChooseSights(u);
    ChooseKeepOut(u);
    if (worst_sample_) ChooseSamples(u);
  }

  /// The optimum of the program within the trust region round u.
  SearchVector Solve(const SearchVector& u, const Tolerance& tolerance) {
    const int d = space_.size();
    const int n = d + (worst_sample_ ? 1 : 0);
    nlopt::opt slsqp(nlopt::LD_SLSQP, n);
    std::vector<double> lower(n), upper(n), x(n);
    for (int i = 0; i < d; ++i) {
      x[i] = u(i);
      lower[i] = u(i) - kTrust;
      upper[i] = u(i) + kTrust;
      if (!space_.round(i)) {
        lower[i] = std::max(lower[i], 0.0);
        upper[i] = std::min(upper[i], 1.0);
        x[i] = std::clamp(x[i], lower[i], upper[i]);
      }
    }
    if (worst_sample_) {
      x[d] = Judge(u).merit;
      lower[d] = x[d] - 100.0;
      upper[d] = x[d] + 100.0;
    }
    slsqp.set_lower_bounds(lower);
    slsqp.set_upper_bounds(upper);
    slsqp.set_max_objective(&Program::Objective, this);
    if (!elements_.empty()) {
      slsqp.add_inequality_mconstraint(&Program::Constraints, this,
                                       std::vector<double>(elements_.size(), 1e-13));
    }
    slsqp.set_xtol_rel(tolerance.x);
    slsqp.set_ftol_rel(tolerance.merit);
    slsqp.set_maxeval(80);
    try {
      double value = 0.0;
      slsqp.optimize(x, value);
    } catch (const nlopt::roundoff_limited&) {
      // As good as the numbers allow: x is what it reached.
    } catch (const std::runtime_error&) {
      // A degenerate quadratic program: x may still be better.
    }
    SearchVector result(d);
    for (int i = 0; i < d; ++i) result(i) = std::isfinite(x[i]) ? x[i] : u(i);
    return result;
  }

 private:
  // ---- Choice of inequalities

  void Add(std::vector<Element>* found, std::size_t most) {
    const auto less = [](const Element& a, const Element& b) { return a.margin < b.margin; };
    const std::size_t kept = std::min(most, found->size());
    std::partial_sort(found->begin(), found->begin() + static_cast<std::ptrdiff_t>(kept),
                      found->end(), less);
    for (std::size_t i = 0; i < kept; ++i) {
      const Element& element = (*found)[i];
      const bool known = std::any_of(elements_.begin(), elements_.end(),
                                     [&](const Element& e) { return e.Same(element); });
      if (!known) elements_.push_back(element);
    }
    found->clear();
  }

  void ChooseHalfSpaces(const SearchVector& u) {
    const Isometry3d X_WC = RigPose(space_.rig(), space_.ToRigFreely(u));
    const double near = kNear * model_.unit();
    const std::size_t most = model_.offsets().size() == 1 ? 8 : 3;
    const ArmMotion& motion = model_.problem().motion;
    std::array<std::vector<Element>, 6> found;
    for (std::size_t o = 0; o < model_.offsets().size(); ++o) {
      const Isometry3d X_CW = (X_WC * model_.offsets()[o]).inverse();
      for (int i = 0; i < motion.size(); ++i) {
        for (int j = 0; j < model_.markers(); ++j) {
          const Vector3d p = X_CW * model_.marker(i, j).p_W;
          for (int k = 0; k < 6; ++k) {
            const double margin = frustum_[k].a.dot(p) + frustum_[k].b;
            if (!(margin < near)) continue;
            found[k].push_back({Element::Kind::kHalfSpace, k, i, j, static_cast<int>(o), margin});
          }
        }
      }
      for (std::vector<Element>& of_plane : found) Add(&of_plane, most);
    }
  }

  void ChooseSights(const SearchVector& u) {
    const Isometry3d X_WC = RigPose(space_.rig(), space_.ToRigFreely(u));
    LoadPlaces({X_WC});
    const double near = kNearSight * model_.unit();
    std::vector<Element> hidden, facing;
    for (int i = 0; i < model_.problem().motion.size(); ++i) {
      const Sights& sights = SightsAt(i);
      const double least_hidden = sights.hidden[0], least_facing = sights.facing[0];
      if (least_hidden < near) {
        hidden.push_back({Element::Kind::kHidden, 0, i, 0, 0, least_hidden});
      }
      if (least_facing < near) {
        facing.push_back({Element::Kind::kFacing, 0, i, 0, 0, least_facing});
      }
    }
    Add(&hidden, 8);
    Add(&facing, 8);
  }

  void ChooseKeepOut(const SearchVector& u) {
    const Vector3d p_WC = RigPose(space_.rig(), space_.ToRigFreely(u)).translation();
    const PlanLimits& limits = model_.problem().limits;
    std::vector<Element> found;
    for (std::size_t i = 0; i < limits.keep_out.size(); ++i) {
      const double margin = DistanceToBox(limits.keep_out[i], p_WC) - limits.clearance;
      if (margin < kNear * model_.unit()) {
        found.push_back({Element::Kind::kKeepOut, static_cast<int>(i), 0, 0, 0, margin});
      }
    }
    Add(&found, 8);
  }

  void ChooseSamples(const SearchVector& u) {
    BatchCameras camera;
    camera.Resize(1);
    camera.Set(0, RigPose(space_.rig(), space_.ToRigFreely(u)));
    std::vector<Element> found;
    for (int i = 0; i < model_.problem().motion.size(); ++i) {
      found.push_back({Element::Kind::kSample, 0, i, 0, 0, SampleMerits(i, camera)[0]});
    }
    Add(&found, 12);
  }

  // ---- Values and derivatives

  // The camera at u, and moved each way along each axis.
  std::vector<Isometry3d> Differences(const SearchVector& u) const {
    std::vector<Isometry3d> poses{RigPose(space_.rig(), space_.ToRigFreely(u))};
    for (int i = 0; i < space_.size(); ++i) {
      for (const double sign : {1.0, -1.0}) {
        SearchVector at = u;
        at(i) += sign * kStep;
        poses.push_back(RigPose(space_.rig(), space_.ToRigFreely(at)));
      }
    }
    return poses;
  }

  // Derivative by u(i) of merits at Differences().
  static double SlopeOf(const std::vector<double>& merits, int i) {
    return (merits[2 * i + 1] - merits[2 * i + 2]) / (2.0 * kStep);
  }

  std::vector<double> SampleMerits(int sample, const BatchCameras& cameras) {
    const PlacementProblem& problem = model_.problem();
    BatchScores scores;
    evaluator_.Score(model_.sample_views()[sample].scene, cameras, 0, cameras.size(), problem.lens,
                     problem.objective.measure, BatchPrecision::kDouble, false, &scores);
    for (double& score : scores.sum) score = model_.Merit(score);
    return scores.sum;
  }

  // Camera poses that SightsAt() is asked about, all offsets of each.
  void LoadPlaces(const std::vector<Isometry3d>& poses) {
    const std::vector<Isometry3d>& offsets = model_.offsets();
    places_.Resize(static_cast<int>(poses.size() * offsets.size()));
    int entry = 0;
    for (const Isometry3d& pose : poses) {
      for (const Isometry3d& offset : offsets) places_.Set(entry++, pose * offset);
    }
    for (Sights& sights : sights_) sights.known = false;
  }

  // Margins of one sample from each loaded pose, worst over its offsets.
  struct Sights {
    bool known{false};
    std::array<double, 7> hidden{}, facing{};
  };
  const Sights& SightsAt(int sample) {
    sights_.resize(model_.problem().motion.size());
    Sights& sights = sights_[sample];
    if (sights.known) return sights;
    sights.known = true;
    evaluator_.CheckObstacles(model_.sample_obstacles()[sample], places_, 0, places_.size(),
                              BatchPrecision::kDouble, &margins_);
    const auto P = static_cast<int>(model_.offsets().size());
    for (int i = 0; i * P < places_.size(); ++i) {
      const auto least = [&](const std::vector<double>& all) {
        return *std::min_element(all.begin() + i * P, all.begin() + (i + 1) * P);
      };
      sights.hidden[i] = least(margins_.occlusion);
      sights.facing[i] = least(margins_.facing);
    }
    return sights;
  }

  static double Objective(unsigned n, const double* x, double* gradient, void* data) {
    return static_cast<Program*>(data)->ObjectiveAt(n, x, gradient);
  }
  double ObjectiveAt(unsigned n, const double* x, double* gradient) {
    const int d = space_.size();
    if (worst_sample_) {
      if (gradient != nullptr) {
        std::fill(gradient, gradient + n, 0.0);
        gradient[d] = 1.0;
      }
      return x[d];
    }
    const SearchVector u = Eigen::Map<const Eigen::VectorXd>(x, d);
    if (gradient == nullptr) {
      scorer_->Load({RigPose(space_.rig(), space_.ToRigFreely(u))});
    } else {
      scorer_->Load(Differences(u));
    }
    scorer_->Scores(BatchPrecision::kDouble, &scores_);
    for (double& score : scores_) score = model_.Merit(score);
    if (gradient != nullptr) {
      for (int i = 0; i < d; ++i) gradient[i] = SlopeOf(scores_, i);
    }
    return scores_[0];
  }

  static void Constraints(unsigned m, double* result, unsigned n, const double* x, double* gradient,
                          void* data) {
    static_cast<Program*>(data)->ConstraintsAt(m, result, n, x, gradient);
  }
  // NLopt's are result <= 0.
  void ConstraintsAt(unsigned m, double* result, unsigned n, const double* x, double* gradient) {
    const int d = space_.size();
    const SearchVector u = Eigen::Map<const Eigen::VectorXd>(x, d);
    const RigVector q_c = space_.ToRigFreely(u);
    X_WC_ = RigPose(space_.rig(), q_c);
    const RigJacobianMatrix J = RigJacobian(space_.rig(), q_c);
    by_u_.resize(6, d);
    for (int i = 0; i < d; ++i) by_u_.col(i) = space_.range(i) * J.col(space_.axis(i));
    views_.resize(model_.offsets().size());
    for (std::size_t o = 0; o < views_.size(); ++o) {
      const Isometry3d& offset = model_.offsets()[o];
      views_[o].X_CW = (X_WC_ * offset).inverse();
      views_[o].by_u.noalias() = AdjointMap(offset.inverse()) * by_u_ / model_.unit();
    }
    LoadPlaces(Places());
    if (worst_sample_) {
      const std::vector<Isometry3d> poses = Differences(u);
      differences_.Resize(static_cast<int>(poses.size()));
      for (std::size_t i = 0; i < poses.size(); ++i)
        differences_.Set(static_cast<int>(i), poses[i]);
    }
    for (unsigned k = 0; k < m; ++k) {
      RowVector slope = RowVector::Zero(n);
      const double value = ValueOf(elements_[k], x, &slope);
      result[k] = -value;
      if (gradient == nullptr) continue;
      for (unsigned i = 0; i < n; ++i) gradient[k * n + i] = -slope(i);
    }
  }

  // The camera's pose, and moved each way along W's axes.
  std::vector<Isometry3d> Places() const {
    std::vector<Isometry3d> places{X_WC_};
    for (int i = 0; i < 3; ++i) {
      for (const double sign : {1.0, -1.0}) {
        places.push_back(X_WC_);
        places.back().translation()(i) += sign * kPlaceStep * model_.unit();
      }
    }
    return places;
  }

  // From values at Places().
  double FromPlaces(const std::array<double, 7>& at, RowVector* slope) const {
    Vector3d by_W;
    for (int i = 0; i < 3; ++i) {
      by_W(i) = (at[2 * i + 1] - at[2 * i + 2]) / (2.0 * kPlaceStep * model_.unit());
    }
    const Vector3d by_v = X_WC_.linear().transpose() * by_W / model_.unit();
    slope->head(space_.size()) = by_v.transpose() * by_u_.topRows<3>();
    return at[0] / model_.unit() - kReserve;
  }

  double ValueOf(const Element& element, const double* x, RowVector* slope) {
    switch (element.kind) {
      case Element::Kind::kHalfSpace: {
        const View& view = views_[element.offset];
        const Vector3d p = view.X_CW * model_.marker(element.sample, element.point).p_W;
        const HalfSpace& half = frustum_[element.index];
        // The point moves by -(v + ω × p) in the frame of the displaced camera.
        Eigen::Matrix<double, 1, 6> by_twist;
        by_twist << -half.a.transpose(), half.a.cross(p).transpose();
        slope->head(space_.size()).noalias() = by_twist * view.by_u;
        return (half.a.dot(p) + half.b) / model_.unit() - kReserve;
      }
      case Element::Kind::kHidden:
      case Element::Kind::kFacing: {
        const Sights& sights = SightsAt(element.sample);
        return FromPlaces(element.kind == Element::Kind::kHidden ? sights.hidden : sights.facing,
                          slope);
      }
      case Element::Kind::kKeepOut: {
        const PlanLimits& limits = model_.problem().limits;
        const std::vector<Isometry3d> places = Places();
        std::array<double, 7> at{};
        for (int i = 0; i < 7; ++i) {
          at[i] = DistanceToBox(limits.keep_out[element.index], places[i].translation()) -
                  limits.clearance;
        }
        return FromPlaces(at, slope);
      }
      case Element::Kind::kSample:
        break;
    }
    const std::vector<double> merits = SampleMerits(element.sample, differences_);
    const int d = space_.size();
    for (int i = 0; i < d; ++i) (*slope)(i) = SlopeOf(merits, i);
    (*slope)(d) = -1.0;
    return merits[0] - x[d];
  }

  const PlacementModel& model_;
  const SearchSpace& space_;
  CameraScorer* scorer_;
  BatchEvaluator evaluator_;
  std::array<HalfSpace, 6> frustum_;
  bool worst_sample_;
  std::vector<Element> elements_;
  Isometry3d X_WC_{Isometry3d::Identity()};
  SearchJacobian by_u_;
  struct View {  // of the camera with one offset
    Isometry3d X_CW;
    SearchJacobian by_u;  // twist by u, per unit
  };
  std::vector<View> views_;
  BatchCameras places_, differences_;
  BatchMargins margins_;
  std::vector<Sights> sights_;
  std::vector<double> scores_;
};

}  // namespace

struct Polisher::State {
  State(const PlacementModel& model, const SearchSpace& search_space, CameraScorer* scorer)
      : space(search_space), program(model, search_space, scorer) {}

  const SearchSpace& space;
  Program program;
  SearchVector u, best;
  Program::Judged here, best_judged;
};

Polisher::Polisher(const PlacementModel& model, const SearchSpace& space, const RigVector& q_c,
                   CameraScorer* scorer)
    : state_(std::make_unique<State>(model, space, scorer)) {
  state_->u = state_->best = space.FromRig(q_c);
  state_->here = state_->best_judged = state_->program.Judge(state_->u);
}

Polisher::~Polisher() = default;
Polisher::Polisher(Polisher&&) noexcept = default;
Polisher& Polisher::operator=(Polisher&&) noexcept = default;

Polisher::Step Polisher::Round(const Tolerance& tolerance) {
  State& s = *state_;
  s.program.Choose(s.u, s.here.margins);
  const SearchVector next = s.program.Solve(s.u, tolerance);
  Program::Judged there = s.program.Judge(next);
  s.here = there;
  Step step;
  step.moved = s.space.Distance(s.u, next);
  step.kept = there.keeps;
  SearchVector at = next;
  if (!there.keeps && s.best_judged.keeps) {
    // Short of a limit that was not in the program, or of rounding: some of the way is allowed.
    for (double share = 1e-9; share < 0.5 && !there.keeps; share *= 30.0) {
      at = next + share * (s.best - next);
      there = s.program.Judge(at);
    }
  }
  const bool better = there.keeps
                          ? !s.best_judged.keeps || there.merit > s.best_judged.merit
                          : !s.best_judged.keeps && there.violation < s.best_judged.violation;
  if (better && s.best_judged.keeps) step.gain = there.merit - s.best_judged.merit;
  if (better) {
    s.best = at;
    s.best_judged = there;
  }
  s.u = next;
  return step;
}

void Polisher::Coarse() {
  Settle(kCoarse);
}

void Polisher::Rough() {
  Settle(kRough);
}

void Polisher::Settle(const Tolerance& tolerance) {
  if (state_->space.size() == 0) return;
  for (int round = 0; round < kRounds; ++round) {
    const Step step = Round(tolerance);
    if (step.kept && step.moved < 0.99 * kTrust) break;
  }
}

void Polisher::Finish() {
  if (state_->space.size() == 0) return;
  for (int round = 0; round < kRounds; ++round) {
    const Step step = Round(kFine);
    if (step.moved < 1e-11) break;
    if (step.kept && step.gain && *step.gain < 1e-12) break;
  }
}

RigVector Polisher::q_c() const {
  return state_->space.ToRig(state_->best);
}

bool Polisher::keeps() const noexcept {
  return state_->best_judged.keeps;
}

double Polisher::merit() const noexcept {
  return state_->best_judged.merit;
}

double Polisher::violation() const noexcept {
  return state_->best_judged.violation;
}

RigVector Polish(const PlacementModel& model, const SearchSpace& space, const RigVector& q_c,
                 CameraScorer* scorer) {
  Polisher polisher(model, space, q_c, scorer);
  polisher.Finish();
  return polisher.q_c();
}

}  // namespace vantage::plan
