#pragma once

#include <string>
#include <vector>

namespace vantage {

/// Text as HTML shows it letter by letter.
[[nodiscard]] std::string Escaped(const std::string& text);

/// One HTML file that needs nothing else: styles, pictures and videos are inside.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);

  void Section(const std::string& heading, const std::string& text = "");
  /// Figures to take in at a glance: (name, value).
  struct Tile {
    std::string name, value;
    bool bad{false};
  };
  void Tiles(const std::vector<Tile>& tiles);
  /// Cells are text; columns of numbers are set flush right.
  void Table(const std::vector<std::string>& titles,
             const std::vector<std::vector<std::string>>& rows);
  /// The picture itself, from a file that gnuplot wrote. Throws Error when it cannot be read.
  void Svg(const std::string& path, const std::string& caption);
  /// A video. Throws Error when it cannot be read.
  void Mp4(const std::string& path, const std::string& caption);
  /// Text with its line breaks, folded away under a title.
  void Folded(const std::string& title, const std::string& text);

  /// Throws Error when the file cannot be written.
  void Write(const std::string& path) const;

 private:
  std::string title_;
  std::string body_;
  std::string contents_;
  int sections_{0};
  int pictures_{0};
};

}  // namespace vantage
