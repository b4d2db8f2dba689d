#include "figure.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "vantage/math/error.h"
#include "vantage/math/format.h"
#include "vantage/report/gnuplot.h"

namespace vantage {
namespace {

constexpr char kFont[] = "font 'DejaVu Sans,12'";
constexpr char kEmptyPlot[] =
    "set label 1 'no finite value' at graph 0.5,0.5 center\nplot [][0.1:10] NaN notitle\nunset "
    "label 1\n";

// A gnuplot comment line ends nothing; an empty line ends a curve.
void AppendRow(const FigureRow& row, std::string* out) {
  if (IsPoint(row)) {
    for (const double value : row) *out += Format("%.9g ", value);
  }
  *out += '\n';
}

}  // namespace

Figure::Figure(std::string name, int width, int height)
    : name_(std::move(name)), width_(width), height_(height) {}

std::string Figure::Data(const std::vector<FigureRow>& rows) {
  const std::string block = "$data" + std::to_string(++blocks_);
  data_ += block + " << EOD\n";
  for (const FigureRow& row : rows) AppendRow(row, &data_);
  data_ += "EOD\n";
  if (std::any_of(rows.begin(), rows.end(), IsPoint)) drawable_.push_back(block);
  return block;
}

Figure& Figure::operator<<(const std::string& command) {
  const bool plot = command.rfind("plot ", 0) == 0;
  const bool draws = std::any_of(drawable_.begin(), drawable_.end(), [&](const std::string& block) {
    return command.find(block + ' ') != std::string::npos;
  });
  commands_ += plot && !draws ? kEmptyPlot : command + '\n';
  return *this;
}

void Figure::Band(double begin, double end, const char* colour) {
  *this << Format(
      "set object %d rectangle from first %.6g, graph 0 to first %.6g, graph 1 behind "
      "fillcolor rgb '%s' fillstyle solid 1.0 noborder",
      ++bands_, begin, end, colour);
}

void Figure::ClearBands() {
  for (; bands_ > 0; --bands_) *this << "unset object " + std::to_string(bands_);
}

void Figure::Draw(const std::string& folder) const {
  const std::string path = folder + "/" + name_ + ".gp";
  {
    std::ofstream script(path);
    const std::string size = std::to_string(width_) + "," + std::to_string(height_);
    script << "# Draws " << name_ << ".png and " << name_ << ".svg.\n"
           << data_ << "set encoding utf8\n";
    // gnuplot keeps settings when the terminal changes: each picture starts from none.
    const std::string begin =
        "set grid linecolor rgb '#e5e7eb' linewidth 0.8\n"
        "set border linecolor rgb '#6b7280'\nset tics textcolor rgb '#374151'\n"
        "set key textcolor rgb '#374151' samplen 2 spacing 1.1 noenhanced\n";
    script << "set terminal pngcairo size " << size << ' ' << kFont << " linewidth 1.3\n"
           << "set output '" << name_ << ".png'\n"
           << begin << commands_ << "unset output\nreset\nset encoding utf8\n"
           << "set terminal svg dynamic enhanced size " << size << ' ' << kFont
           << " linewidth 1.3 background '#ffffff'\n"
           << "set output '" << name_ << ".svg'\n"
           << begin << commands_ << "unset output\n";
    script.flush();
    if (!script) throw WriteError(path);
  }
  RunGnuplot(path);
}

bool IsPoint(const FigureRow& row) {
  return !row.empty() &&
         std::all_of(row.begin(), row.end(), [](double value) { return std::isfinite(value); });
}

std::vector<FigureRow> Thinned(const std::vector<FigureRow>& rows, std::size_t buckets) {
  if (rows.size() <= 2 * buckets) return rows;
  std::vector<FigureRow> thin;
  const std::size_t size = (rows.size() + buckets - 1) / buckets;
  const auto usable = [](const FigureRow& row) {
    return row.size() >= 2 && std::isfinite(row[0]) && std::isfinite(row[1]);
  };
  for (std::size_t at = 0; at < rows.size(); at += size) {
    const std::size_t end = std::min(at + size, rows.size());
    std::size_t least = end, greatest = end;
    bool gap = false;
    for (std::size_t i = at; i < end; ++i) {
      if (!usable(rows[i])) {
        gap = true;
        continue;
      }
      if (least == end || rows[i][1] < rows[least][1]) least = i;
      if (greatest == end || rows[i][1] > rows[greatest][1]) greatest = i;
    }
    if (least != end) {
      thin.push_back(rows[std::min(least, greatest)]);
      if (least != greatest) thin.push_back(rows[std::max(least, greatest)]);
    }
    if (gap) thin.push_back({});
  }
  return thin;
}

}  // namespace vantage
