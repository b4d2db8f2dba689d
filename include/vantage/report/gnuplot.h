#pragma once

#include <string>

namespace vantage {

/// A string of gnuplot's language, quotes included, that holds exactly this text: a file's name, or text that
/// gnuplot shows as it shows enhanced text.
[[nodiscard]] std::string GnuplotString(const std::string& text);

/// Enhanced text that shows `text` letter by letter, on one line. For GnuplotString().
[[nodiscard]] std::string GnuplotLiteral(const std::string& text);

/// Runs a gnuplot script. Its output files are the script's affair.
///
/// @param script_path  File with gnuplot commands; relative names in it are relative to its folder.
/// Throws Error when gnuplot is not installed or ends with an error, with what it said.
void RunGnuplot(const std::string& script_path);

}  // namespace vantage
