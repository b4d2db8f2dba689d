#include "oracle_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "oracles.h"
#include "vantage/math/error.h"

namespace vantage::test {
namespace {

struct File {
  Json json = Json::object();
  std::string error;
};

const File& TheFile() {
  static const File file = [] {
    File read;
    try {
      read.json = ReadJsonFile(OraclePath());
      if (!read.json.is_object()) read.error = "is not an object";
    } catch (const std::exception& error) {
      read.error = error.what();
    }
    return read;
  }();
  return file;
}

std::set<const Json*>& NodesRead() {
  static std::set<const Json*> nodes;
  return nodes;
}

// Values that are no claim about a configuration, by the end of their path, and why.
const std::vector<std::pair<std::string, std::string>>& NotJudged() {
  static const std::vector<std::pair<std::string, std::string>> paths{
      {"/R_monotone_violations/", "a statistic of the search that found the optimum"},
      {"/placement/O9_other_measures/", "optima of an instance that the file does not state"},
      {"/placement/O5", "stated in words that no test here has"}};
  return paths;
}

// Sections that hold claims; of cases, what is expected.
bool HoldsClaims(const std::string& path) {
  if (path.rfind("/meta/", 0) == 0) return false;
  return path.rfind("/cases/", 0) != 0 || path.find("/expected/") != std::string::npos;
}

struct Coverage {
  int judged{0};
  std::map<std::string, int> reasons;
  std::vector<std::string> missed;
};

void Cover(const Json& node, const std::string& path, bool read, Coverage* coverage) {
  read = read || NodesRead().count(&node) == 1;
  if (node.is_structured()) {
    std::size_t i = 0;
    for (const auto& [key, value] : node.items()) {
      Cover(value, path + "/" + (node.is_array() ? std::to_string(i++) : key), read, coverage);
    }
    return;
  }
  if (node.is_string() || !HoldsClaims(path)) return;
  if (read) {
    ++coverage->judged;
    return;
  }
  for (const auto& [part, reason] : NotJudged()) {
    if (path.find(part) != std::string::npos) {
      ++coverage->reasons[reason];
      return;
    }
  }
  coverage->missed.push_back(path);
}

// After a run of all tests: every number, truth value and null of the file was read by some test.
class JudgesEveryNumber : public ::testing::Environment {
 public:
  void TearDown() override {
    if (::testing::GTEST_FLAG(filter) != "*") return;
    Coverage coverage;
    Cover(TheFile().json, "", false, &coverage);
    std::cout << "[ COVERAGE ] " << TheFile().json.value("cases", Json::array()).size()
              << " cases, " << coverage.judged << " values judged";
    for (const auto& [reason, count] : coverage.reasons) {
      std::cout << "; " << count << " not (" << reason << ")";
    }
    std::cout << '\n';
    for (const std::string& path : coverage.missed) ADD_FAILURE() << path << " is not judged";
  }
};

const ::testing::Environment* const kJudgesEveryNumber =
    ::testing::AddGlobalTestEnvironment(new JudgesEveryNumber);

std::string Sanitised(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    name += letter || (c >= '0' && c <= '9') ? c : '_';
  }
  return name;
}

}  // namespace

Node Oracles() {
  return Node(&TheFile().json);
}

const Json& Node::read() const {
  NodesRead().insert(json_);
  return *json_;
}

std::vector<std::pair<std::string, Node>> Node::items() const {
  std::vector<std::pair<std::string, Node>> items;
  for (const auto& [key, value] : json_->items()) items.emplace_back(key, Node(&value));
  return items;
}

std::vector<Node> Node::elements() const {
  std::vector<Node> elements;
  for (const Json& value : *json_) elements.emplace_back(&value);
  return elements;
}

const std::string& ReadError() {
  return TheFile().error;
}

std::ostream& operator<<(std::ostream& stream, const Entry& entry) {
  return stream << entry.id;
}

std::vector<Entry> Entries(const std::string& pointer) {
  std::vector<Entry> entries;
  const Json::json_pointer path(pointer);
  if (!TheFile().json.contains(path)) return entries;
  const Json& section = TheFile().json[path];
  std::set<std::string> names;
  const auto add = [&](const std::string& id, const Json& json) {
    std::string name = Sanitised(id);
    if (name.empty() || !names.insert(name).second) {
      name += "_entry_" + std::to_string(entries.size());
    }
    entries.push_back({name, Node(&json)});
  };
  if (section.is_object()) {
    for (const auto& [key, value] : section.items()) add(key, value);
  } else {
    for (const Json& value : section) {
      const bool named = value.is_object() && value.contains("id") && value["id"].is_string();
      add(named ? value["id"].get<std::string>() : "", value);
    }
  }
  return entries;
}

std::string NameOf(const ::testing::TestParamInfo<Entry>& info) {
  return info.param.id;
}

Eigen::MatrixXd Matrix(const Node& rows) {
  return ParseJsonMatrix(rows.read(), "");
}

Eigen::VectorXd Vector(const Node& values) {
  return ParseJsonVector(values.read(), "");
}

Eigen::Vector3d Point(const Node& values) {
  return Vector(values);
}

::testing::AssertionResult JacobianNear(const Eigen::MatrixXd& actual,
                                        const Eigen::MatrixXd& expected, double tolerance) {
  if (actual.rows() != expected.rows() || actual.cols() != expected.cols()) {
    return ::testing::AssertionFailure()
           << "is " << actual.rows() << "x" << actual.cols() << ", expected " << expected.rows()
           << "x" << expected.cols();
  }
  const double bound = tolerance * expected.cwiseAbs().maxCoeff();
  const double worst = (actual - expected).cwiseAbs().maxCoeff();
  if (worst <= bound) return ::testing::AssertionSuccess();  // false for a NaN
  return ::testing::AssertionFailure() << "differs by " << worst << " > " << bound << "\n"
                                       << actual << "\nexpected\n"
                                       << expected;
}

::testing::AssertionResult RelativelyNear(double actual, double expected, double tolerance) {
  const double bound = tolerance * std::abs(expected);
  if (std::abs(actual - expected) <= bound) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << actual << ", expected " << expected << ", differs by "
                                       << actual - expected << ", allowed is " << bound;
}

::testing::AssertionResult WNear(const Measure& measure, double expected) {
  if (measure.status != MeasureStatus::kOk) {
    return ::testing::AssertionFailure() << "not measured: " << static_cast<int>(measure.status);
  }
  const double scale = std::pow(measure.sigma(0), measure.size());
  const double bound = expected == 0.0 ? kZeroTolerance * scale : kMeasureTolerance * expected;
  if (std::abs(measure.w - expected) <= bound) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "w is " << measure.w << ", expected " << expected
                                       << ", differs by " << measure.w - expected << " > " << bound;
}

::testing::AssertionResult GradientNear(const Eigen::VectorXd& actual,
                                        const Eigen::VectorXd& expected, double w) {
  const double largest = expected.cwiseAbs().maxCoeff();
  return JacobianNear(
      actual, expected,
      std::max(kGradientTolerance, largest > 0.0 ? kSigmaTolerance * w / largest : 0.0));
}

::testing::AssertionResult SigmaNear(const Measure& measure, const Node& expected) {
  const Eigen::VectorXd sigma = Vector(expected);
  if (sigma.size() != measure.size()) {
    return ::testing::AssertionFailure()
           << measure.size() << " singular values, expected " << sigma.size();
  }
  const double worst = (measure.sigma - sigma).cwiseAbs().maxCoeff();
  if (worst <= kSigmaTolerance * sigma(0)) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "singular values differ by " << worst << ":\n"
                                       << measure.sigma.transpose() << "\nexpected\n"
                                       << sigma.transpose();
}

Evaluated Evaluate(OracleCase input) {
  Evaluated e{std::move(input), {}, {}, {}, {}, {}, {}, {}, {}, {}};
  e.kinematics = ComputeKinematics(e.input.arm, e.input.q);
  e.X_WC = CameraPoseOf(e.input.camera, e.kinematics.X_WE);
  e.views = ViewPoints(e.input.points, e.kinematics.X_WE, e.X_WC);
  e.input.features.Evaluate(e.input.camera.model, e.views, &e.rows);
  e.J_v = ImageJacobianOf(e, e.rows);
  e.J_c = e.J_v * e.kinematics.J_WE_W;
  e.view = MeasureOf(e.J_v, e.input.task_dimension);
  e.arm = MeasureOf(e.kinematics.J_WE_W, e.input.task_dimension);
  e.composite = MeasureOf(e.J_c, e.input.task_dimension);
  return e;
}

FeatureJacobian ImageJacobianOf(const Evaluated& e, const FeatureRows& rows) {
  const Eigen::Vector3d p_WE = e.kinematics.X_WE.translation();
  return e.input.camera.eye_in_hand ? ImageJacobianEyeInHand(rows, e.X_WC, p_WE)
                                    : ImageJacobian(rows.L_body, e.X_WC, p_WE);
}

}  // namespace vantage::test
