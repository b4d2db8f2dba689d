#pragma once

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

/// @file
/// Reads the oracle file: cases computed apart from this code, by finite differences of the forward map at 40
/// digits.

namespace vantage::test {

/// tests/data/oracles.json, or the file that VANTAGE_ORACLES names.
[[nodiscard]] inline std::string OraclePath() {
  const char* other = std::getenv("VANTAGE_ORACLES");
  return other != nullptr ? other : VANTAGE_TEST_DATA "/oracles.json";
}

[[nodiscard]] inline nlohmann::json ReadOracles() {
  std::ifstream file(OraclePath());
  if (!file) throw std::runtime_error("cannot open " + OraclePath());
  return nlohmann::json::parse(file);
}

/// A matrix written as a list of rows.
[[nodiscard]] inline Eigen::MatrixXd OracleMatrix(const nlohmann::json& rows) {
  Eigen::MatrixXd result(rows.size(), rows.at(0).size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows[i].size(); ++j) result(i, j) = rows[i][j].get<double>();
  }
  return result;
}

[[nodiscard]] inline Eigen::Isometry3d OraclePose(const nlohmann::json& rows) {
  return Eigen::Isometry3d(Eigen::Matrix4d(OracleMatrix(rows)));
}

}  // namespace vantage::test
