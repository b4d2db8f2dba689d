// write_corpus DECODE_FOLDER TCPQ_FOLDER: good inputs for the fuzz targets to start from.

#include <cstdio>
#include <fstream>
#include <string>

#include "../raw_client.h"
#include "../samples.h"

namespace vantage {
namespace {

bool failed = false;

void Write(const std::string& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  failed = failed || !file.good();
}

// As decode_fuzz wants it: the selector in place of the fingerprint.
void WriteDecode(const std::string& folder, int type, Bytes bytes) {
  bytes.erase(bytes.begin(), bytes.begin() + 8);
  bytes.insert(bytes.begin(), static_cast<std::uint8_t>(type << 1 | 1));
  Write(folder + "/type" + std::to_string(type), bytes);
}

Bytes Joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  using namespace vantage;
  if (argc != 3) return 2;
  const std::string decode = argv[1];
  WriteDecode(decode, 0, test::Encoded(test::SampleJointState()));
  WriteDecode(decode, 1, test::Encoded(test::SampleJointCommand()));
  WriteDecode(decode, 2, test::Encoded(test::SampleCameraPose()));
  WriteDecode(decode, 3, test::Encoded(test::SampleImageFeatures()));
  WriteDecode(decode, 4, test::Encoded(test::SampleObservability()));
  WriteDecode(decode, 5, test::Encoded(test::SampleServoStatus()));
  WriteDecode(decode, 6, test::Encoded(test::SampleGroundTruth()));
  WriteDecode(decode, 7, test::Encoded(test::SampleServoRecord()));
  WriteDecode(decode, 8, test::Encoded(test::SampleServoSetup()));
  WriteDecode(decode, 9, test::Encoded(test::SampleCameraImage()));
  const std::string tcpq = argv[2];
  Write(tcpq + "/stream",
        Joined({test::ClientHello(), test::NameMessage(2, "J.*_[A-Z]+"),
                test::PublishMessage("JOINT_STATE", Bytes(20)), test::NameMessage(2, "(A*)*B"),
                test::NameMessage(3, "J.*_[A-Z]+"), test::PublishMessage("AAAAAAAAAAAAAAAA", {})}));
  return failed ? 1 : 0;
}
