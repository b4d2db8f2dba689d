#pragma once

#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "vantage/config/oracle_case.h"
#include "vantage/features/feature_set.h"
#include "vantage/observability/measures.h"
#include "vantage/robot/kinematics.h"

/// @file
/// The oracle file of this run (tests/data/oracles.json, or the file that VANTAGE_ORACLES names), its
/// tolerances, and a case evaluated by the library.

namespace vantage::test {

using Json = nlohmann::json;

/// A value of the file that notes when it is read: at the end of a full run each number that no test read is
/// named (see JudgesEveryNumber in oracle_file.cpp).
class Node {
 public:
  explicit Node(const Json* json) : json_(json) {}

  [[nodiscard]] Node at(const std::string& key) const { return Node(&json_->at(key)); }
  [[nodiscard]] Node at(std::size_t i) const { return Node(&json_->at(i)); }
  [[nodiscard]] bool contains(const std::string& key) const { return json_->contains(key); }
  [[nodiscard]] std::size_t size() const { return json_->size(); }
  [[nodiscard]] std::vector<std::pair<std::string, Node>> items() const;
  [[nodiscard]] std::vector<Node> elements() const;
  [[nodiscard]] bool is_null() const { return read().is_null(); }
  template <typename T>
  [[nodiscard]] T get() const {
    return read().get<T>();
  }
  operator double() const { return get<double>(); }  // NOLINT: numbers are what nodes are for

  /// The value and all below it, as read.
  [[nodiscard]] const Json& read() const;
  /// The same without a note: inputs, ids, prose.
  [[nodiscard]] const Json& raw() const { return *json_; }

 private:
  const Json* json_;
};

/// The file; an empty object when it could not be read. ReadError() says why.
[[nodiscard]] Node Oracles();
[[nodiscard]] const std::string& ReadError();

/// One entry of a list, or one value of an object, for a test of its own.
struct Entry {
  std::string id;  ///< Letters, digits and underscores.
  Node node;
};
std::ostream& operator<<(std::ostream& stream, const Entry& entry);

/// The entries of the list at `pointer` by their "id", or the values of the object there by their key.
/// Empty when the file has no such section. Entries without an id are named by their number, and so
/// are those whose id was used before: the test OracleFile.NamesEachEntryOnce tells.
[[nodiscard]] std::vector<Entry> Entries(const std::string& pointer);

/// Name of an instance.
[[nodiscard]] std::string NameOf(const ::testing::TestParamInfo<Entry>& info);

// Tolerances of the file's meta.
inline constexpr double kFeatureTolerance = 1e-12;   // · max(1, |v|)
inline constexpr double kJacobianTolerance = 1e-11;  // · max|J|
inline constexpr double kSigmaTolerance = 1e-12;     // · σ_1
inline constexpr double kMeasureTolerance = 1e-9;    // · w
inline constexpr double kZeroTolerance = 1e-9;       // · σ_1^s, where w is 0
inline constexpr double kGradientTolerance = 1e-7;   // · max|g|

[[nodiscard]] Eigen::MatrixXd Matrix(const Node& rows);
[[nodiscard]] Eigen::VectorXd Vector(const Node& values);
[[nodiscard]] Eigen::Vector3d Point(const Node& values);

/// max|a - b| <= tolerance · max|b|.
[[nodiscard]] ::testing::AssertionResult JacobianNear(const Eigen::MatrixXd& actual,
                                                      const Eigen::MatrixXd& expected,
                                                      double tolerance = kJacobianTolerance);

/// |a - b| <= tolerance · |b|.
[[nodiscard]] ::testing::AssertionResult RelativelyNear(double actual, double expected,
                                                        double tolerance);

/// w of a measure: relative where it is not zero.
[[nodiscard]] ::testing::AssertionResult WNear(const Measure& measure, double expected);

/// max|a - b| <= kGradientTolerance · max|b|. Where the gradient vanishes (at a maximum of w, say) what is
/// left is the rounding of terms of w's own size: kSigmaTolerance · w.
[[nodiscard]] ::testing::AssertionResult GradientNear(const Eigen::VectorXd& actual,
                                                      const Eigen::VectorXd& expected, double w);

[[nodiscard]] ::testing::AssertionResult SigmaNear(const Measure& measure, const Node& expected);

/// A case as the library sees it.
struct Evaluated {
  OracleCase input;
  Kinematics kinematics;
  Eigen::Isometry3d X_WC;
  PointViews views;
  FeatureRows rows;
  FeatureJacobian J_v;
  TaskJacobian J_c;
  Measure view, arm, composite;
};
[[nodiscard]] Evaluated Evaluate(OracleCase input);

/// The image Jacobian of features of this case seen by its camera.
[[nodiscard]] FeatureJacobian ImageJacobianOf(const Evaluated& e, const FeatureRows& rows);

}  // namespace vantage::test
