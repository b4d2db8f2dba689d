#include "html_page.h"

#include <cstdint>
#include <fstream>
#include <sstream>

#include "vantage/math/error.h"

namespace vantage {
namespace {

constexpr char kStyle[] = R"css(
:root { color-scheme: light; }
body { font: 15px/1.5 "DejaVu Sans", system-ui, sans-serif; color: #1f2937; background: #f3f4f6; margin: 0; }
header { background: #111827; color: #f9fafb; padding: 22px max(24px, calc(50vw - 600px)); }
header h1 { margin: 0; font-size: 24px; }
nav a { color: #93c5fd; margin-right: 16px; text-decoration: none; font-size: 14px; }
nav { margin-top: 8px; }
main { max-width: 1200px; margin: 0 auto; padding: 8px 24px 60px; }
section { background: #fff; border: 1px solid #e5e7eb; border-radius: 8px; padding: 8px 24px 20px; margin-top: 20px; }
h2 { font-size: 19px; margin: 12px 0 6px; }
p { margin: 6px 0 10px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fill, minmax(170px, 1fr)); gap: 12px; margin: 12px 0; }
.tile { background: #f9fafb; border: 1px solid #e5e7eb; border-radius: 6px; padding: 8px 12px; }
.tile b { display: block; font-size: 19px; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
.tile span { color: #6b7280; font-size: 13px; }
.tile.bad b { color: #b91c1c; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14px; font-variant-numeric: tabular-nums; }
th { text-align: left; color: #6b7280; font-weight: 600; border-bottom: 2px solid #e5e7eb; padding: 5px 12px 5px 0; }
td { border-bottom: 1px solid #f0f1f3; padding: 4px 12px 4px 0; white-space: nowrap; }
th.n, td.n { text-align: right; }
figure { margin: 10px 0; }
figure svg { width: 100%; height: auto; display: block; }
figure video { width: 100%; max-width: 860px; margin: 0 auto; display: block; }
figcaption { color: #6b7280; font-size: 14px; margin-top: 4px; }
summary { cursor: pointer; }
pre { background: #f9fafb; border: 1px solid #e5e7eb; padding: 12px; overflow-x: auto; font-size: 13px; }
)css";

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw Error("cannot read " + path);
  return text.str();
}

std::string Base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint8_t byte = i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0;
      triple = triple << 8 | byte;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[triple >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

bool IsNumber(const std::string& cell) {
  return cell.empty() || cell == "-" || cell.find_first_of("0123456789") == 0 ||
         (cell[0] == '-' && cell.size() > 1);
}

void ReplaceAll(std::string* text, const std::string& from, const std::string& to) {
  for (std::size_t at = text->find(from); at != std::string::npos;
       at = text->find(from, at + to.size())) {
    text->replace(at, from.size(), to);
  }
}

// gnuplot gives elements of every picture the same names; within one page they must differ.
std::string WithOwnNames(std::string svg, int picture) {
  svg.erase(0, svg.find("<svg"));
  const std::string mark = "p" + std::to_string(picture) + "_";
  ReplaceAll(&svg, "id='", "id='" + mark);
  ReplaceAll(&svg, "id=\"", "id=\"" + mark);
  ReplaceAll(&svg, "href='#", "href='#" + mark);
  ReplaceAll(&svg, "href=\"#", "href=\"#" + mark);
  ReplaceAll(&svg, "url(#", "url(#" + mark);
  return svg;
}

}  // namespace

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '&':
        escaped += "&amp;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

HtmlPage::HtmlPage(const std::string& title) : title_(title) {}

void HtmlPage::Section(const std::string& heading, const std::string& text) {
  const std::string id = "s" + std::to_string(++sections_);
  if (sections_ > 1) body_ += "</section>\n";
  body_ += "<section id=\"" + id + "\"><h2>" + Escaped(heading) + "</h2>\n";
  if (!text.empty()) body_ += "<p>" + Escaped(text) + "</p>\n";
  contents_ += "<a href=\"#" + id + "\">" + Escaped(heading) + "</a>";
}

void HtmlPage::Tiles(const std::vector<Tile>& tiles) {
  body_ += "<div class=\"tiles\">";
  for (const Tile& tile : tiles) {
    body_ += std::string("<div class=\"tile") + (tile.bad ? " bad" : "") + "\"><b>" +
             Escaped(tile.value) + "</b><span>" + Escaped(tile.name) + "</span></div>";
  }
  body_ += "</div>\n";
}

void HtmlPage::Table(const std::vector<std::string>& titles,
                     const std::vector<std::vector<std::string>>& rows) {
  std::vector<const char*> classes(titles.size(), " class=\"n\"");
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size() && i < classes.size(); ++i) {
      if (!IsNumber(row[i])) classes[i] = "";
    }
  }
  body_ += "<div class=\"scroll\"><table><tr>";
  for (std::size_t i = 0; i < titles.size(); ++i) {
    body_ += std::string("<th") + classes[i] + ">" + Escaped(titles[i]) + "</th>";
  }
  body_ += "</tr>\n";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (std::size_t i = 0; i < row.size() && i < classes.size(); ++i) {
      body_ += std::string("<td") + classes[i] + ">" + Escaped(row[i]) + "</td>";
    }
    body_ += "</tr>\n";
  }
  body_ += "</table></div>\n";
}

void HtmlPage::Svg(const std::string& path, const std::string& caption) {
  body_ += "<figure>" + WithOwnNames(ReadFile(path), ++pictures_) + "<figcaption>" +
           Escaped(caption) + "</figcaption></figure>\n";
}

void HtmlPage::Mp4(const std::string& path, const std::string& caption) {
  body_ += "<figure><video controls muted loop src=\"data:video/mp4;base64," +
           Base64(ReadFile(path)) + "\"></video><figcaption>" + Escaped(caption) +
           "</figcaption></figure>\n";
}

void HtmlPage::Folded(const std::string& title, const std::string& text) {
  body_ += "<details><summary>" + Escaped(title) + "</summary><pre>" + Escaped(text) +
           "</pre></details>\n";
}

void HtmlPage::Write(const std::string& path) const {
  std::ofstream file(path, std::ios::binary);
  file << "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
       << "<meta name=\"viewport\" content=\"width=device-width\"><title>" << Escaped(title_)
       << "</title><style>" << kStyle << "</style></head>\n<body><header><h1>" << Escaped(title_)
       << "</h1><nav>" << contents_ << "</nav></header><main>\n"
       << body_ << (sections_ > 0 ? "</section>\n" : "") << "</main></body></html>\n";
  file.flush();
  if (!file) throw WriteError(path);
}

}  // namespace vantage
