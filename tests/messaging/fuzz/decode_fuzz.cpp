// libFuzzer target: bytes from outside through every decoder. The first byte chooses the type; with an
// odd one the right fingerprint is put in front, which a fuzzer would take long to guess.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "../samples.h"

namespace vantage {
namespace {

template <typename Value>
void TryDecode(const Value& sample, bool help, std::vector<std::uint8_t> bytes) {
  if (help) {
    const Bytes good = test::Encoded(sample);
    bytes.insert(bytes.begin(), good.begin(), good.begin() + 8);
  }
  Value value = sample;
  if (Decode(bytes.data(), bytes.size(), &value) != Refusal::kNone) return;
  // What was accepted must survive a round trip: it is within the bounds of what we send.
  const Bytes again = test::Encoded(value);
  Value copy;
  if (Decode(again.data(), again.size(), &copy) != Refusal::kNone) std::abort();
}

}  // namespace
}  // namespace vantage

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace vantage;
  if (size == 0) return 0;
  const bool help = (data[0] & 1) != 0;
  const std::vector<std::uint8_t> bytes(data + 1, data + size);
  switch (data[0] >> 1 & 15) {
    case 0:
      TryDecode(test::SampleJointState(), help, bytes);
      break;
    case 1:
      TryDecode(test::SampleJointCommand(), help, bytes);
      break;
    case 2:
      TryDecode(test::SampleCameraPose(), help, bytes);
      break;
    case 3:
      TryDecode(test::SampleImageFeatures(), help, bytes);
      break;
    case 4:
      TryDecode(test::SampleObservability(), help, bytes);
      break;
    case 5:
      TryDecode(test::SampleServoStatus(), help, bytes);
      break;
    case 6:
      TryDecode(test::SampleGroundTruth(), help, bytes);
      break;
    case 7:
      TryDecode(test::SampleServoRecord(), help, bytes);
      break;
    case 8:
      TryDecode(test::SampleServoSetup(), help, bytes);
      break;
    default:
      TryDecode(test::SampleCameraImage(), help, bytes);
  }
  return 0;
}
