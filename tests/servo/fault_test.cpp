// One fault after another in mid-motion, in lockstep: what the servo does, how soon the arm stands, and that it
// goes on when the fault is over. The simulator's monitor looks at every command.
//
// The table in docs/control.md is what happened here; VANTAGE_WRITE_DOCS=1 in the environment writes it anew.

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "read_file.h"
#include "servo_cell.h"

namespace vantage {
namespace {

using namespace test;  // NOLINT: the cell

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kBegin = 0.4;     // in mid-motion [s]
constexpr double kDuration = 0.8;  // [s]

using Spoil = std::function<void(Deliveries*)>;

struct Fault {
  const char* name;  // as in the table
  Spoil spoil;
  HoldReason reason;  // kNone: the servo goes on
  bool refuses;       // messages are refused, and counted
};

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.name;
}

// Applies f to each message of a kind.
Spoil Joint(std::function<void(JointState*)> f) {
  return [f](Deliveries* d) {
    for (JointState& v : d->joints) f(&v);
  };
}
Spoil Pose(std::function<void(CameraPose*)> f) {
  return [f](Deliveries* d) {
    for (CameraPose& v : d->poses) f(&v);
  };
}
Spoil Image(std::function<void(ImageFeatures*)> f) {
  return [f](Deliveries* d) {
    for (ImageFeatures& v : d->images) f(&v);
  };
}

// The first message of a kind again and again.
template <typename T>
std::function<void(std::vector<T>*)> Frozen() {
  auto kept = std::make_shared<std::optional<T>>();
  return [kept](std::vector<T>* messages) {
    for (T& v : *messages) {
      if (!*kept) *kept = v;
      v = **kept;
    }
  };
}

// Each message changes places with the one after it.
template <typename T>
std::function<void(std::vector<T>*)> Reordered() {
  auto kept = std::make_shared<std::optional<T>>();
  return [kept](std::vector<T>* messages) {
    std::vector<T> out;
    for (const T& v : *messages) {
      if (*kept) {
        out.push_back(v);
        out.push_back(**kept);
        kept->reset();
      } else {
        *kept = v;
      }
    }
    *messages = out;
  };
}

template <typename T>
void Twice(std::vector<T>* messages) {
  const std::vector<T> copy = *messages;
  messages->insert(messages->end(), copy.begin(), copy.end());
}

// Ten messages for each one, a tenth of a period apart, oldest first.
void Burst(Deliveries* d) {
  std::vector<JointState> joints;
  for (const JointState& v : d->joints) {
    for (int i = 9; i >= 0; --i) {
      joints.push_back(v);
      joints.back().stamp -= FromSeconds(i * 0.1 * kPeriod);
    }
  }
  d->joints = joints;
  std::vector<ImageFeatures> images;
  for (const ImageFeatures& v : d->images) {
    for (int i = 9; i >= 0; --i) {
      images.push_back(v);
      images.back().exposure -= FromSeconds(i * 0.1 * kPeriod);
    }
  }
  d->images = images;
}

Spoil LoseMarkers(int count) {
  return Image([count](ImageFeatures* v) {
    for (int i = 0; i < count; ++i) v->markers[static_cast<std::size_t>(i)].valid = false;
  });
}

std::vector<Fault> Faults() {
  const Duration ahead = std::chrono::seconds(10);
  auto joints_frozen = Frozen<JointState>();
  auto poses_frozen = Frozen<CameraPose>();
  auto images_frozen = Frozen<ImageFeatures>();
  auto joints_reordered = Reordered<JointState>();
  auto images_reordered = Reordered<ImageFeatures>();
  auto stuck = std::make_shared<std::optional<JointVector>>();
  return {
      {"joint state: a NaN position", Joint([](JointState* v) { v->q(1) = kNan; }),
       HoldReason::kStaleJointState, true},
      {"joint state: an infinite velocity", Joint([](JointState* v) { v->qdot(0) = kInf; }),
       HoldReason::kStaleJointState, true},
      {"joint state: one joint too few", Joint([](JointState* v) { v->q.conservativeResize(2); }),
       HoldReason::kStaleJointState, true},
      {"joint state: none any more", [](Deliveries* d) { d->joints.clear(); },
       HoldReason::kStaleJointState, false},
      {"joint state: frozen, stamp and all",
       [joints_frozen](Deliveries* d) { joints_frozen(&d->joints); }, HoldReason::kStaleJointState,
       true},
      {"joint state: stamps 10 s ahead", Joint([ahead](JointState* v) { v->stamp += ahead; }),
       HoldReason::kStaleJointState, true},
      {"joint state: reordered in pairs",
       [joints_reordered](Deliveries* d) { joints_reordered(&d->joints); }, HoldReason::kNone,
       true},
      {"joint state: every message twice", [](Deliveries* d) { Twice(&d->joints); },
       HoldReason::kNone, true},
      {"encoders stuck, stamps go on", Joint([stuck](JointState* v) {
         if (!*stuck) *stuck = v->q;
         v->q = **stuck;
       }),
       HoldReason::kArmNotFollowing, false},
      {"camera pose: a NaN", Pose([](CameraPose* v) { v->X_WC.translation().x() = kNan; }),
       HoldReason::kStaleCameraPose, true},
      {"camera pose: no rotation", Pose([](CameraPose* v) { v->X_WC.linear() *= 1.1; }),
       HoldReason::kStaleCameraPose, true},
      {"camera pose: none any more", [](Deliveries* d) { d->poses.clear(); },
       HoldReason::kStaleCameraPose, false},
      {"camera pose: frozen, stamp and all",
       [poses_frozen](Deliveries* d) { poses_frozen(&d->poses); }, HoldReason::kStaleCameraPose,
       true},
      {"features: a NaN pixel", Image([](ImageFeatures* v) { v->markers[0].pixel.x() = kNan; }),
       HoldReason::kStaleFeatures, true},
      {"features: an infinite pixel",
       Image([](ImageFeatures* v) { v->markers[1].pixel.y() = kInf; }), HoldReason::kStaleFeatures,
       true},
      {"features: none any more", [](Deliveries* d) { d->images.clear(); },
       HoldReason::kStaleFeatures, false},
      {"features: frozen, stamp and all",
       [images_frozen](Deliveries* d) { images_frozen(&d->images); }, HoldReason::kStaleFeatures,
       true},
      {"features: exposed 10 s ahead", Image([ahead](ImageFeatures* v) { v->exposure += ahead; }),
       HoldReason::kStaleFeatures, true},
      {"features: reordered in pairs",
       [images_reordered](Deliveries* d) { images_reordered(&d->images); }, HoldReason::kNone,
       true},
      {"features: every message twice", [](Deliveries* d) { Twice(&d->images); }, HoldReason::kNone,
       true},
      {"one of two markers lost", LoseMarkers(1), HoldReason::kTooFewFeatures, false},
      {"all markers lost", LoseMarkers(2), HoldReason::kTooFewFeatures, false},
      {"ten times the messages", Burst, HoldReason::kNone, false},
      {"everything silent",
       [](Deliveries* d) {
         d->joints.clear();
         d->poses.clear();
         d->images.clear();
       },
       HoldReason::kStaleJointState, false},
  };
}

const JointVector kStart = Joints({-0.9, 0.2, -0.6});
const JointVector kGoal = Joints({0.6, 0.9, -1.5});

struct Outcome {
  ServoState state{ServoState::kIdle};  // at the end of the fault
  HoldReason reason{HoldReason::kNone};
  double hold_after{0.0};  // from the fault's begin; 0: went on [s]
  double rest_after{0.0};
  std::int64_t refused{0};
  std::int64_t violations{0};
  double converged_after{0.0};  // from the fault's end [s]
};

Outcome RunFault(const Fault& fault) {
  Outcome outcome;
  ServoCell cell(PumaView(), kStart, kGoal);
  while (cell.time() < kBegin) (void)cell.Tick();
  ServoOutput output = cell.Tick();
  EXPECT_GT(output.command.qdot.norm(), 0.3) << "not in mid-motion";
  const double begin = cell.time();
  const std::int64_t refused = output.status.refused_messages;
  while (cell.time() < begin + kDuration) {
    output = cell.Tick(fault.spoil);
    const double since = cell.time() - begin;
    const bool holds =
        output.status.state == ServoState::kHolding || output.status.state == ServoState::kFault;
    if (holds && outcome.hold_after == 0.0) outcome.hold_after = since;
    if (holds && outcome.rest_after == 0.0 && output.command.qdot.isZero(0.0)) {
      outcome.rest_after = since;
    }
  }
  outcome.state = output.status.state;
  outcome.reason = output.status.reason;
  outcome.refused = output.status.refused_messages - refused;
  const double end = cell.time();
  if (outcome.state == ServoState::kFault) {
    // The operator looks at it, and starts it again.
    cell.servo().SetEnabled(false);
    (void)cell.Tick();
    cell.servo().SetEnabled(true);
  }
  while (cell.time() < end + 8.0 && output.status.state != ServoState::kConverged) {
    output = cell.Tick();
  }
  EXPECT_EQ(output.status.state, ServoState::kConverged)
      << Name(output.status.state) << " " << Name(output.status.reason);
  outcome.converged_after = cell.time() - end;
  outcome.violations = cell.arm().violations().total();
  return outcome;
}

// Longest time from a fault to rest: the input's limit of age, and braking from full speed. The last good
// message may come with the fault, a limit is passed in the period after, and braking takes whole periods.
double LongestStop(HoldReason reason) {
  const StalenessLimits limits;
  const double braking = 1.5 / 8.0 + 3.0 * kPeriod;
  switch (reason) {
    case HoldReason::kStaleJointState:
      return limits.joint_state + braking;
    case HoldReason::kStaleCameraPose:
      return limits.camera_pose + braking;
    case HoldReason::kTooFewFeatures:
      return limits.marker + 0.04 + braking;  // an image's time and delay more
    case HoldReason::kStaleFeatures:
      return limits.features + braking;
    default:
      return 0.55 + braking;
  }
}

std::string TableRow(const Fault& fault, const Outcome& o) {
  char row[300];
  const auto rounded = [](double s) { return std::ceil(s / 0.05 - 1e-9) * 0.05; };
  if (o.hold_after > 0.0) {
    std::snprintf(row, sizeof(row), "| %s | %s %s | %.2f s | %.2f s | %s | %s | none |\n",
                  fault.name, Name(o.state), Name(o.reason), rounded(o.hold_after),
                  rounded(o.rest_after), o.refused > 0 ? "yes" : "-",
                  o.state == ServoState::kFault ? "once restarted" : "by itself");
  } else {
    std::snprintf(row, sizeof(row), "| %s | goes on | - | - | %s | - | none |\n", fault.name,
                  o.refused > 0 ? "yes" : "-");
  }
  return row;
}

class EveryFault : public ::testing::TestWithParam<Fault> {};

TEST_P(EveryFault, StopsInTimeNamesItAndGoesOnAfterwards) {
  const Fault& fault = GetParam();
  const Outcome o = RunFault(fault);
  EXPECT_EQ(o.violations, 0);
  EXPECT_EQ(o.refused > 0, fault.refuses);
  if (fault.reason == HoldReason::kNone) {
    EXPECT_EQ(o.hold_after, 0.0) << Name(o.reason);
    return;
  }
  EXPECT_EQ(o.reason, fault.reason) << Name(o.reason);
  EXPECT_EQ(o.state, fault.reason == HoldReason::kArmNotFollowing ? ServoState::kFault
                                                                  : ServoState::kHolding);
  EXPECT_GT(o.rest_after, 0.0) << "still moving";
  EXPECT_LE(o.rest_after, LongestStop(fault.reason));
}

INSTANTIATE_TEST_SUITE_P(Lockstep, EveryFault, ::testing::ValuesIn(Faults()), [](const auto& test) {
  std::string name = test.param.name;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
});

// The document tells what happens.
TEST(FaultTable, IsWhatHappens) {
  std::string table =
      "| fault | the servo | holds after | at rest after | messages refused | resumes | commands "
      "outside limits |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const Fault& fault : Faults()) table += TableRow(fault, RunFault(fault));
  const std::string path = VANTAGE_DOCS "/control.md";
  std::string document = test::ReadFile(path);
  const std::string begin = "<!-- fault table: by tests/servo/fault_test.cpp -->\n";
  const std::string end = "<!-- end of fault table -->";
  const auto from = document.find(begin);
  const auto to = document.find(end);
  ASSERT_TRUE(from != std::string::npos && to != std::string::npos) << path;
  if (std::getenv("VANTAGE_WRITE_DOCS") != nullptr) {
    document.replace(from + begin.size(), to - from - begin.size(), table);
    std::ofstream(path) << document;
    return;
  }
  EXPECT_EQ(document.substr(from + begin.size(), to - from - begin.size()), table)
      << "run fault_test with VANTAGE_WRITE_DOCS=1";
}

// A servo that is killed and started again in mid-motion takes over a moving arm.
TEST(Restart, InMidMotionTakesTheArmAsItMoves) {
  ServoCell cell(PumaView(), kStart, kGoal);
  while (cell.time() < kBegin) (void)cell.Tick();
  const JointVector before = cell.Tick().command.qdot;
  ASSERT_GT(before.norm(), 0.3);
  cell.RestartServo();
  const ServoOutput& first = cell.Tick();
  EXPECT_EQ(first.status.state, ServoState::kAcquiring);
  EXPECT_LE((first.command.qdot - before).lpNorm<Eigen::Infinity>(), 0.3);
  ServoOutput output;
  while (cell.time() < 8.0 && output.status.state != ServoState::kConverged) output = cell.Tick();
  EXPECT_EQ(output.status.state, ServoState::kConverged);
  EXPECT_EQ(cell.arm().violations().velocity + cell.arm().violations().position, 0);
}

// A goal beyond a joint's stop: the arm goes as far as it may, stands, and says why.
TEST(JointLimit, IsNamedWhenNoWayLeadsOn) {
  ArmModel arm = PumaArm();
  std::vector<JointLimits> limits = arm.limits();
  limits[0].upper = 0.1;
  ViewModel view = PumaView();
  view.arm = arm.WithLimits(limits);
  ServoCell cell(view, kStart, kGoal);
  ServoOutput output;
  while (cell.time() < 8.0) output = cell.Tick();
  EXPECT_EQ(output.status.state, ServoState::kHolding);
  EXPECT_EQ(output.status.reason, HoldReason::kJointLimit) << Name(output.status.reason);
  EXPECT_EQ(cell.arm().violations().total(), 0);
  EXPECT_NEAR(cell.arm().q()(0), 0.1 - ServoOptions().limit_margin, 2e-3);
}

}  // namespace
}  // namespace vantage
