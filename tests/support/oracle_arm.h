#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "oracle_json.h"
#include "vantage/robot/arm_model.h"

/// @file
/// The arms of the oracle file.

namespace vantage::test {

[[nodiscard]] inline Eigen::Isometry3d OraclePose(const nlohmann::json& rows) {
  return Eigen::Isometry3d(Eigen::Matrix4d(OracleMatrix(rows)));
}

[[nodiscard]] inline JointVector OracleJoints(const nlohmann::json& q) {
  const auto values = q.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
}

[[nodiscard]] inline std::vector<DhRow> OracleRows(const nlohmann::json& robot) {
  std::vector<DhRow> rows;
  for (const auto& joint : robot.at("joints")) {
    DhRow row;
    row.kind = joint.at("type") == "P" ? JointKind::kPrismatic : JointKind::kRevolute;
    row.theta = joint.value("theta", 0.0);
    row.d = joint.value("d", 0.0);
    row.a = joint.at("a").get<double>();
    row.alpha = joint.at("alpha").get<double>();
    row.offset = joint.at("offset").get<double>();
    rows.push_back(row);
  }
  return rows;
}

/// The arm of a case; its limits are wide (±10 rad or m).
[[nodiscard]] inline ArmModel OracleArm(const nlohmann::json& robot) {
  const std::vector<DhRow> rows = OracleRows(robot);
  const auto convention =
      robot.at("convention") == "modified" ? DhConvention::kModified : DhConvention::kStandard;
  return ArmModel(robot.at("name").get<std::string>(), convention, rows,
                  std::vector<JointLimits>(rows.size(), {-10.0, 10.0, 1.0, 10.0}),
                  OraclePose(robot.at("base")), OraclePose(robot.at("tool")));
}

}  // namespace vantage::test
