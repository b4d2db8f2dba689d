// Hostile messages in bulk: good messages changed at random, by a seeded generator, in the ways that
// break decoders. Nothing may crash (build with the asan preset), allocate without bound, or come out
// with a value that the rest of the program does not expect.

#include <array>
#include <cstdlib>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "allocation_meter.h"
#include "samples.h"
#include "vantage/math/spatial.h"
#include "vantage/messaging/codec.h"

namespace vantage {
namespace {

constexpr int kDefaultMutations = 1'000'000;

// VANTAGE_MUTATIONS asks for another number.
int NumMutations() {
  const char* text = std::getenv("VANTAGE_MUTATIONS");
  return text != nullptr ? std::atoi(text) : kDefaultMutations;
}

using Random = std::mt19937;

std::size_t Below(std::size_t limit, Random* random) {
  return std::uniform_int_distribution<std::size_t>(0, limit - 1)(*random);
}

// Bytes that counts, lengths, exponents and signs turn bad at.
std::uint8_t SpecialByte(Random* random) {
  constexpr std::array<std::uint8_t, 8> kSpecial{0x00, 0x01, 0x7f, 0x80, 0xff, 0xfe, 0x10, 0x40};
  return kSpecial[Below(kSpecial.size(), random)];
}

// Overwrites `length` bytes with one byte repeated: NaNs, infinities, huge and negative counts.
void Fill(std::size_t length, Bytes* bytes, Random* random) {
  const std::size_t at = Below(bytes->size(), random) & ~std::size_t{3};
  const std::uint8_t byte = SpecialByte(random);
  for (std::size_t i = at; i < std::min(at + length, bytes->size()); ++i) (*bytes)[i] = byte;
}

// A multiple of 4 bytes from the start is where counts and numbers begin, strings aside.
void PutCount(Bytes* bytes, Random* random) {
  constexpr std::array<std::uint32_t, 10> kCounts{0,  1,  2,          17,         33,
                                                  64, 65, 0x7fffffff, 0x80000000, 0x0fffffff};
  const std::size_t at = Below(bytes->size(), random) & ~std::size_t{3};
  const std::uint32_t count = kCounts[Below(kCounts.size(), random)];
  for (std::size_t i = 0; i < 4 && at + i < bytes->size(); ++i) {
    (*bytes)[at + i] = static_cast<std::uint8_t>(count >> (24 - 8 * i));
  }
}

void PutDouble(Bytes* bytes, Random* random) {
  // NaN, infinity, -infinity, 1e300, a subnormal: their two leading bytes say enough.
  constexpr std::array<std::uint16_t, 5> kLeading{0x7ff8, 0x7ff0, 0xfff0, 0x7e37, 0x0000};
  const std::size_t at = Below(bytes->size(), random) & ~std::size_t{3};
  const std::uint16_t leading = kLeading[Below(kLeading.size(), random)];
  for (std::size_t i = 0; i < 8 && at + i < bytes->size(); ++i) {
    (*bytes)[at + i] = static_cast<std::uint8_t>(i < 2 ? leading >> (8 - 8 * i) : 0);
  }
}

void ChangeOnce(Bytes* bytes, Random* random) {
  if (bytes->empty()) return;
  switch (Below(9, random)) {
    case 0:
      (*bytes)[Below(bytes->size(), random)] ^= static_cast<std::uint8_t>(1U << Below(8, random));
      break;
    case 1:
      (*bytes)[Below(bytes->size(), random)] = SpecialByte(random);
      break;
    case 2:
      Fill(4, bytes, random);
      break;
    case 3:
      Fill(8, bytes, random);
      break;
    case 4:
      PutCount(bytes, random);
      break;
    case 5:
      PutDouble(bytes, random);
      break;
    case 6:
      bytes->resize(Below(bytes->size() + 1, random));
      break;
    case 7:
      bytes->insert(bytes->begin() + static_cast<std::ptrdiff_t>(Below(bytes->size(), random)),
                    1 + Below(16, random), SpecialByte(random));
      break;
    default: {
      const std::size_t at = Below(bytes->size(), random);
      const std::size_t length = std::min(1 + Below(16, random), bytes->size() - at);
      const auto begin = bytes->begin() + static_cast<std::ptrdiff_t>(at);
      bytes->erase(begin, begin + static_cast<std::ptrdiff_t>(length));
    }
  }
}

Bytes Mutated(const Bytes& original, Random* random) {
  Bytes bytes = original;
  const std::size_t changes = 1 + Below(4, random);
  for (std::size_t i = 0; i < changes; ++i) ChangeOnce(&bytes, random);
  // Nearly always the right fingerprint, so that the checks behind it are reached.
  if (Below(20, random) != 0) {
    std::copy_n(original.begin(), std::min<std::size_t>(8, bytes.size()), bytes.begin());
  }
  return bytes;
}

// What every decoded value promises.
bool Sound(const JointState& value) {
  return value.q.size() >= 1 && value.q.size() == value.qdot.size() && value.q.allFinite() &&
         value.qdot.allFinite();
}
bool Sound(const JointCommand& value) {
  return value.q.size() >= 1 && value.q.size() == value.qdot.size() && value.q.allFinite() &&
         value.qdot.allFinite();
}
bool Sound(const CameraPose& value) {
  return value.X_WC.matrix().allFinite() &&
         (value.X_WC.linear() * value.X_WC.linear().transpose()).isIdentity(1e-9);
}
bool Sound(const ImageFeatures& value) {
  bool sound = value.count >= 0 && value.count <= kMaxMarkers && value.exposure <= value.stamp;
  for (int i = 0; sound && i < value.count; ++i) sound = value.markers[i].pixel.allFinite();
  return sound;
}
bool Sound(const ObservabilityReport& value) {
  return value.composite.sigma.allFinite() && value.axes.allFinite() && value.n <= kMaxJoints &&
         std::string(Name(value.cause)) != "UNKNOWN";
}
bool Sound(const ServoStatus& value) {
  return std::isfinite(value.error_px) && std::string(Name(value.state)) != "UNKNOWN" &&
         std::string(Name(value.reason)) != "UNKNOWN";
}
bool Sound(const GroundTruth& value) {
  return value.q.size() >= 1 && value.q.allFinite() && std::isfinite(value.worst_error);
}
bool Sound(const CameraImage& value) {
  return value.width > 0 && value.height > 0 && value.row_stride >= 0 &&
         static_cast<std::int64_t>(value.row_stride) * (value.height - 1) <=
             static_cast<std::int64_t>(value.data.size());
}

bool Sound(const ServoRecord& value) {
  for (const PeriodRecord& period : value.periods) {
    const PeriodInputs& inputs = period.inputs;
    if (inputs.has_joints && !(inputs.joints.q.size() >= 1 && inputs.joints.q.allFinite() &&
                               inputs.joints.q.size() == inputs.joints.qdot.size())) {
      return false;
    }
    if (inputs.has_pose && !IsPose(inputs.pose.X_WC)) return false;
    if (inputs.has_features &&
        !(inputs.features.count >= 0 && inputs.features.count <= kMaxMarkers &&
          IsPose(inputs.features.X_WC))) {
      return false;
    }
  }
  return value.lost >= 0;
}
bool Sound(const PandaStatus& value) {
  return value.q.size() >= 1 && value.q.size() == value.qdot.size() && value.q.allFinite() &&
         value.qdot.allFinite() && std::string(Name(value.mode)) != "UNKNOWN";
}
bool Sound(const ServoSetup& value) {
  return value.start >= Time{} && value.scenario.size() < kMaxRecordBytes;
}

struct Tally {
  RefusalCounts outcomes{};
};

template <typename Value>
void Bombard(const Value& sample, int mutations, unsigned seed, Tally* tally) {
  const Bytes original = test::Encoded(sample);
  Random random(seed);
  Value value;
  for (int i = 0; i < mutations; ++i) {
    const Bytes bytes = Mutated(original, &random);
    test::ResetAllocated();
    const Refusal outcome = Decode(bytes.data(), bytes.size(), &value);
    const std::size_t allocated = test::Allocated();
    ++tally->outcomes[static_cast<int>(outcome)];
    // The costliest array has rows of 24 bytes for a byte or less each.
    ASSERT_LE(allocated, 64 * (bytes.size() + 64)) << "mutation " << i << ": " << Name(outcome);
    ASSERT_TRUE(outcome != Refusal::kNone || Sound(value)) << "mutation " << i;
  }
}

TEST(MutatedMessages, AreRefusedOrSound) {
  const int share = NumMutations() / 11;
  Tally tally;
  Bombard(test::SampleJointState(), share, 1, &tally);
  Bombard(test::SampleJointCommand(), share, 2, &tally);
  Bombard(test::SampleCameraPose(), share, 3, &tally);
  Bombard(test::SampleImageFeatures(), share, 4, &tally);
  Bombard(test::SampleObservability(), share, 5, &tally);
  Bombard(test::SampleServoStatus(), share, 6, &tally);
  Bombard(test::SampleCameraImage(), share, 7, &tally);
  Bombard(test::SampleGroundTruth(), share, 8, &tally);
  Bombard(test::SampleServoRecord(), share, 9, &tally);
  Bombard(test::SampleServoSetup(), share, 10, &tally);
  Bombard(test::SamplePandaStatus(), share, 11, &tally);

  // The bombardment is worth its time only if it reaches every check it can reach: those on size and
  // order are not within a message, and the guard leaves nothing for LCM's own decoder to refuse.
  for (int i = 0; i < kNumRefusals; ++i) {
    const auto refusal = static_cast<Refusal>(i);
    if (refusal == Refusal::kTooLarge || refusal == Refusal::kReordered ||
        refusal == Refusal::kFuture) {
      continue;
    }
    if (refusal == Refusal::kUndecodable) {
      EXPECT_EQ(tally.outcomes[i], 0);
    } else {
      EXPECT_GT(tally.outcomes[i], 0) << Name(refusal);
    }
    RecordProperty(Name(refusal), std::to_string(tally.outcomes[i]));
  }
}

}  // namespace
}  // namespace vantage
