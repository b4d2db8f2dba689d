#pragma once

#include <string>
#include <utility>
#include <vector>

/// @file
/// Pictures by gnuplot: one script a picture, with its data in it, drawn as PNG and as SVG.

namespace vantage {

/// One line of data: its numbers in order. A row without numbers is a gap in a line.
using FigureRow = std::vector<double>;

/// Colours that people with any colour vision tell apart (P. Tol, "Colour schemes", SRON technical note
/// 09-002, "bright"), and those with a meaning.
struct Palette {
  static constexpr const char* kLines[] = {"#4477aa", "#ee6677", "#228833", "#ccbb44",
                                           "#66ccee", "#aa3377", "#555555", "#e08030"};
  static constexpr int kCount = 8;
  static constexpr const char* kLimit = "#b91c1c";
  static constexpr const char* kMoving = "#dbeafe";   // Band: the camera moves.
  static constexpr const char* kHolding = "#fee2e2";  // Band: the servo holds.
  [[nodiscard]] static const char* Line(int i) { return kLines[i % kCount]; }
};

/// A picture under construction.
class Figure {
 public:
  /// @param width, height  [px].
  Figure(std::string name, int width, int height);

  /// Adds data and gives the name to plot it by. Numbers that are not finite become gaps.
  [[nodiscard]] std::string Data(const std::vector<FigureRow>& rows);

  /// Appends a command. Text that is not the program's own goes through GnuplotLiteral() and GnuplotString(). In the place of a plot
  /// whose data hold no point, which gnuplot refuses to draw, stands a line that says so.
  Figure& operator<<(const std::string& command);

  /// A band in the background of the next plots, over time [s], from bottom to top.
  void Band(double begin, double end, const char* colour);
  void ClearBands();

  /// Writes folder/name.gp and draws folder/name.png and folder/name.svg from it.
  /// Throws Error as RunGnuplot() does.
  void Draw(const std::string& folder) const;

 private:
  std::string name_;
  int width_, height_;
  std::string data_, commands_;
  std::vector<std::string> drawable_;  // Blocks that hold a point.
  int blocks_{0};
  int bands_{0};
};

/// Whether a row holds numbers, all finite.
[[nodiscard]] bool IsPoint(const FigureRow& row);

/// The same curve with at most some 2 `buckets` points: of each bucket the least and the greatest y, so that
/// no peak is lost. Rows are (x, y); gaps stay.
[[nodiscard]] std::vector<FigureRow> Thinned(const std::vector<FigureRow>& rows,
                                             std::size_t buckets = 700);

}  // namespace vantage
