#pragma once

#include <string>
#include <vector>

namespace vantage {

/// Writes every channel of a log whose type is known as a table of its own: folder/CHANNEL.csv, one line
/// a message, one column a value (arrays: a column an element), numbers to the last bit. Arrays of structs
/// become tables of theirs: folder/CHANNEL.periods.csv, one line an element.
///
/// The first column, log_time, is the logger's wall clock [s]; units are those of lcm_types/.
/// @return the paths written, in order.
/// Throws Error when the log cannot be read or a file not be written.
std::vector<std::string> ExportCsv(const std::string& log_path, const std::string& folder);

}  // namespace vantage
