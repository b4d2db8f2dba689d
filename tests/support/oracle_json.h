#pragma once

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

/// @file
/// Reads the oracle file (tests/data/oracles.json, or the file that VANTAGE_ORACLES names): cases
/// computed apart from this code, by finite differences of the forward map at 40 digits.

namespace vantage::test {

[[nodiscard]] inline nlohmann::json ReadOracles() {
  const char* other = std::getenv("VANTAGE_ORACLES");
  const std::string path = other != nullptr ? other : VANTAGE_TEST_DATA "/oracles.json";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path);
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

}  // namespace vantage::test
