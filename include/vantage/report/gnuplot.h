#pragma once

#include <string>

namespace vantage {

/// Runs a gnuplot script. Its output files are the script's affair.
///
/// @param script_path  File with gnuplot commands; relative names in it are relative to its folder.
/// Throws Error when gnuplot is not installed or ends with an error, with what it said.
void RunGnuplot(const std::string& script_path);

}  // namespace vantage
