#include "vantage/vision/disc_blob.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "vantage/math/angles.h"
#include "vantage/vision/disc_image.h"

namespace vantage {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kMaxRowsOfDisc = 512;
constexpr int kRingSamples = 24;

// Columns [left, right] of the disc in one row.
struct Run {
  int left{0}, right{-1};
};

// The image inside a window, dark discs seen as bright ones: grey levels that rise into the disc.
struct Rising {
  const GreyView& image;
  PixelWindow window;
  int flip;  // 255 for dark discs, 0 for bright ones.

  [[nodiscard]] int at(int u, int v) const noexcept { return image.at(u, v) ^ flip; }
  [[nodiscard]] bool holds(int u, int v) const noexcept { return window.contains(u, v); }
};

// How far one can go from a pixel in steps of `stride` bytes before the level of two pixels together
// falls by `drop`; -1 when it does not within `reach` steps.
int WalkToEdge(const std::uint8_t* pixel, std::ptrdiff_t stride, int flip, int level, int drop,
               int reach) noexcept {
  const int least = 2 * (level - drop);
  int here = reach > 0 ? pixel[stride] ^ flip : 0;
  for (int step = 1; step < reach; ++step) {
    const int next = pixel[(step + 1) * stride] ^ flip;
    if (here + next < least) return step - 1;
    here = next;
  }
  return -1;
}

// Mean of the pixel and its neighbours.
int LevelAround(const Rising& rising, int u, int v) noexcept {
  int sum = 0;
  int count = 0;
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x) {
      if (!rising.holds(x, y)) continue;
      sum += rising.at(x, y);
      ++count;
    }
  }
  return sum / count;
}

struct Levels {
  double disc{0.0}, ring{0.0};
  [[nodiscard]] double contrast() const noexcept { return disc - ring; }
};

// Level of the ring along one line through the disc: what lies half a disc's radius beyond the edges.
bool LevelsAlong(const Rising& rising, int u, int v, bool along_row, int level, int drop, int reach,
                 Levels* levels, MarkerFault* fault) noexcept {
  const int du = along_row ? 1 : 0;
  const int dv = along_row ? 0 : 1;
  const PixelWindow& window = rising.window;
  const int room_ahead =
      along_row ? window.u + window.width - 1 - u : window.v + window.height - 1 - v;
  const int room_behind = along_row ? u - window.u : v - window.v;
  const std::ptrdiff_t stride = along_row ? 1 : rising.image.stride;
  const std::uint8_t* const pixel = rising.image.row(v) + u;
  const int ahead =
      WalkToEdge(pixel, stride, rising.flip, level, drop, std::min(reach, room_ahead));
  const int behind = ahead < 0 ? -1
                               : WalkToEdge(pixel, -stride, rising.flip, level, drop,
                                            std::min(reach, room_behind));
  if (behind < 0) {
    *fault = MarkerFault::kNoContrast;
    return false;
  }
  const int half = (ahead + behind + 1) / 2;
  const int beyond = std::max(1, half / 2) + 1;
  double sum = 0.0;
  int count = 0;
  for (const int step : {ahead + beyond, -behind - beyond}) {
    const int x = u + step * du;
    const int y = v + step * dv;
    if (!rising.holds(x, y)) continue;
    sum += rising.at(x, y);
    ++count;
  }
  if (count == 0) {
    *fault = MarkerFault::kTouchesWindow;
    return false;
  }
  levels->ring = sum / count;
  const int middle_u = u + du * (ahead - behind) / 2;
  const int middle_v = v + dv * (ahead - behind) / 2;
  levels->disc = std::max(rising.at(middle_u, middle_v), LevelAround(rising, middle_u, middle_v));
  return true;
}

// The connected run of pixels above the threshold in a row that meets columns [left, right].
// Notches between its ends are filled: they are noise, or they spoil the moments and are found there.
bool FindRun(const std::uint8_t* row, int flip, int threshold, const PixelWindow& window, Run near,
             Run* run) noexcept {
  const int first = window.u;
  const int last = window.u + window.width - 1;
  const auto inside = [&](int u) { return (row[u] ^ flip) > threshold; };
  int left = near.left;
  while (left <= near.right && !inside(left)) ++left;
  if (left > near.right) return false;
  int right = near.right;
  while (!inside(right)) --right;
  while (left > first && inside(left - 1)) --left;
  while (right < last && inside(right + 1)) ++right;
  *run = {left, right};
  return true;
}

struct Runs {
  std::array<Run, kMaxRowsOfDisc> rows;
  int top{0}, count{0};
  MarkerFault fault{MarkerFault::kNone};
};

// Fills the disc row by row from (u, v). Discs are convex: one run to a row.
void Fill(const Rising& rising, int u, int v, int threshold, int max_size, Runs* runs) noexcept {
  const PixelWindow& window = rising.window;
  std::array<Run, kMaxRowsOfDisc / 2> above;
  Run start;
  if (!FindRun(rising.image.row(v), rising.flip, threshold, window, {u, u}, &start)) {
    runs->fault = MarkerFault::kNoContrast;
    return;
  }
  const auto refuse = [&](const Run& run, int row) {
    if (run.right - run.left >= max_size) return MarkerFault::kTooLarge;
    const int last_row = window.v + window.height - 1;
    const int last_column = window.u + window.width - 1;
    if (run.left > window.u && run.right < last_column && row > window.v && row < last_row) {
      return MarkerFault::kNone;
    }
    const bool border = run.left == 0 || run.right == rising.image.width - 1 || row == 0 ||
                        row == rising.image.height - 1;
    return border ? MarkerFault::kTouchesBorder : MarkerFault::kTouchesWindow;
  };
  if ((runs->fault = refuse(start, v)) != MarkerFault::kNone) return;
  int up = 0;
  Run run = start;
  while (FindRun(rising.image.row(v - up - 1), rising.flip, threshold, window, run, &run)) {
    if ((runs->fault = refuse(run, v - up - 1)) != MarkerFault::kNone) return;
    if (up >= std::min(max_size, kMaxRowsOfDisc / 2)) {
      runs->fault = MarkerFault::kTooLarge;
      return;
    }
    above[up++] = run;
  }
  for (int i = 0; i < up; ++i) runs->rows[up - 1 - i] = above[i];
  runs->rows[up] = start;
  runs->top = v - up;
  runs->count = up + 1;
  run = start;
  for (int row = v + 1; FindRun(rising.image.row(row), rising.flip, threshold, window, run, &run);
       ++row) {
    if ((runs->fault = refuse(run, row)) != MarkerFault::kNone) return;
    if (runs->count >= std::min(max_size, kMaxRowsOfDisc)) {
      runs->fault = MarkerFault::kTooLarge;
      return;
    }
    runs->rows[runs->count++] = run;
  }
}

// Area, centroid and central second moments.
struct Moments {
  double area{0.0};
  Vector2d mean{Vector2d::Zero()};
  Matrix2d covariance{Matrix2d::Zero()};
  double edge{0.0};      // Sum of w (1 - w): what lies between disc and ring.
  double skewness{0.0};  // Norm of the third central moments, whitened: 0 for an ellipse.
};

// Sums of w, w x, ... over an area, x and y about some origin.
struct RawSums {
  double s0{0.0}, sx{0.0}, sy{0.0}, sxx{0.0}, sxy{0.0}, syy{0.0};
  double sxxx{0.0}, sxxy{0.0}, sxyy{0.0}, syyy{0.0};
};

// Norm of the third central moments after whitening by the covariance.
double Skewness(const RawSums& s, double mx, double my, const Matrix2d& covariance) noexcept {
  const double n = s.s0;
  // Central moments from raw ones.
  const double xxx = s.sxxx / n - 3.0 * mx * s.sxx / n + 2.0 * mx * mx * mx;
  const double yyy = s.syyy / n - 3.0 * my * s.syy / n + 2.0 * my * my * my;
  const double xxy = s.sxxy / n - my * s.sxx / n - 2.0 * mx * s.sxy / n + 2.0 * mx * mx * my;
  const double xyy = s.sxyy / n - mx * s.syy / n - 2.0 * my * s.sxy / n + 2.0 * mx * my * my;
  // z = W (x - m) with W the inverse of the covariance's lower triangular root: z = (a x, b x + c y).
  const double l = std::sqrt(covariance(0, 0));
  const double m = covariance(1, 0) / l;
  const double d = std::sqrt(std::max(1e-12, covariance(1, 1) - m * m));
  const double a = 1.0 / l;
  const double b = -m / (l * d);
  const double c = 1.0 / d;
  const double z111 = a * a * a * xxx;
  const double z112 = a * a * (b * xxx + c * xxy);
  const double z122 = a * (b * b * xxx + 2.0 * b * c * xxy + c * c * xyy);
  const double z222 =
      b * b * b * xxx + 3.0 * b * b * c * xxy + 3.0 * b * c * c * xyy + c * c * c * yyy;
  return std::sqrt(z111 * z111 + 3.0 * z112 * z112 + 3.0 * z122 * z122 + z222 * z222);
}

Moments Centre(const RawSums& s, const Vector2d& origin) noexcept {
  Moments moments;
  moments.area = s.s0;
  if (s.s0 <= 0.0) return moments;
  const double mx = s.sx / s.s0;
  const double my = s.sy / s.s0;
  moments.mean = origin + Vector2d(mx, my);
  const double xy = s.sxy / s.s0 - mx * my;
  moments.covariance << s.sxx / s.s0 - mx * mx, xy, xy, s.syy / s.s0 - my * my;
  if (moments.covariance(0, 0) > 0.0) moments.skewness = Skewness(s, mx, my, moments.covariance);
  return moments;
}

// Moments of the runs, every pixel counting fully.
Moments BinaryMoments(const Runs& runs) noexcept {
  const Vector2d origin(runs.rows[runs.count / 2].left, runs.top);
  RawSums s;
  for (int i = 0; i < runs.count; ++i) {
    const double n = runs.rows[i].right - runs.rows[i].left + 1;
    const double x = 0.5 * (runs.rows[i].left + runs.rows[i].right) - origin.x();
    const double y = i;
    s.s0 += n;
    s.sx += n * x;
    s.sy += n * y;
    s.sxx += n * (x * x + (n * n - 1.0) / 12.0);
    s.sxy += n * x * y;
    s.syy += n * y * y;
  }
  return Centre(s, origin);
}

// Sums over one row; reductions in single precision, in lanes the compiler may choose.
struct RowSums {
  float s0{0.0F}, sx{0.0F}, sxx{0.0F}, sxxx{0.0F}, edge{0.0F};
};

RowSums WeighRow(const std::uint8_t* row, int left, int right, float origin, float scale,
                 float offset, float stretch, float shift) noexcept {
  float s0 = 0.0F;
  float sx = 0.0F;
  float sxx = 0.0F;
  float sxxx = 0.0F;
  float edge = 0.0F;
  const float start = static_cast<float>(left) - origin;
  const int count = right - left + 1;
  const std::uint8_t* const pixel = row + left;
#pragma omp simd reduction(+ : s0, sx, sxx, sxxx, edge)
  for (int i = 0; i < count; ++i) {
    const float x = start + static_cast<float>(i);
    const float raw = scale * static_cast<float>(pixel[i]) + offset;
    const float cut = stretch * raw + shift;
    const float w = cut < 0.0F ? 0.0F : (cut > 1.0F ? 1.0F : cut);
    const float wx = w * x;
    s0 += w;
    sx += wx;
    sxx += wx * x;
    sxxx += wx * x * x;
    edge += w * (1.0F - w);
  }
  return {s0, sx, sxx, sxxx, edge};
}

// Moments with grey weights over the runs and `margin` pixels around.
Moments WeightedMoments(const Rising& rising, const Runs& runs, int margin, const Levels& levels,
                        double trim) noexcept {
  const double contrast = levels.contrast();
  // Weight of the rising level g: (g - ring) / contrast, then stretched about one half.
  const double sign = rising.flip == 0 ? 1.0 : -1.0;
  const auto scale = static_cast<float>(sign / contrast);
  const auto offset =
      static_cast<float>(((rising.flip == 0 ? 0.0 : 255.0) - levels.ring) / contrast);
  const double gain = 1.0 / (1.0 - 2.0 * trim);
  const auto stretch = static_cast<float>(gain);
  const auto shift = static_cast<float>(0.5 - 0.5 * gain);

  const PixelWindow& window = rising.window;
  // Near the middle, to keep the sums small: they are taken in single precision along a row.
  const Run& middle = runs.rows[runs.count / 2];
  const int half = runs.count / 2;
  const Vector2d origin((middle.left + middle.right) / 2, runs.top + half);
  RawSums s;
  double edge = 0.0;
  for (int i = -margin; i < runs.count + margin; ++i) {
    const int v = runs.top + i;
    if (v < window.v || v >= window.v + window.height) continue;
    int left = window.u + window.width;
    int right = window.u;
    for (int j = std::max(0, i - margin); j <= std::min(runs.count - 1, i + margin); ++j) {
      left = std::min(left, runs.rows[j].left);
      right = std::max(right, runs.rows[j].right);
    }
    left = std::max(window.u, left - margin);
    right = std::min(window.u + window.width - 1, right + margin);
    const RowSums row = WeighRow(rising.image.row(v), left, right, static_cast<float>(origin.x()),
                                 scale, offset, stretch, shift);
    const double y = i - half;
    s.s0 += row.s0;
    s.sx += row.sx;
    s.sxx += row.sxx;
    s.sxxx += row.sxxx;
    s.sy += row.s0 * y;
    s.sxy += row.sx * y;
    s.sxxy += row.sxx * y;
    s.syy += row.s0 * y * y;
    s.sxyy += row.sx * y * y;
    s.syyy += row.s0 * y * y * y;
    edge += row.edge;
  }
  Moments moments = Centre(s, origin);
  moments.edge = edge;
  return moments;
}

// Ramanujan's approximation; its error is below 1e-3 for axes up to 1 : 5.
double Perimeter(const Vector2d& semi_axes) noexcept {
  const double a = semi_axes.y();
  const double b = semi_axes.x();
  return kPi * (3.0 * (a + b) - std::sqrt((3.0 * a + b) * (a + 3.0 * b)));
}

// Level and noise of the disc's inner half.
void ReadInside(const Rising& rising, const Runs& runs, double* level, double* noise) noexcept {
  const int first = runs.count / 4;
  const int last = std::max(first, runs.count - 1 - runs.count / 4);
  std::int64_t sum = 0;
  std::int64_t squares = 0;
  int count = 0;
  for (int i = first; i <= last; ++i) {
    const Run& run = runs.rows[i];
    const int quarter = (run.right - run.left + 1) / 4;
    const std::uint8_t* const row = rising.image.row(runs.top + i);
    for (int u = run.left + quarter; u <= run.right - quarter; ++u) {
      const int g = row[u] ^ rising.flip;
      sum += g;
      squares += g * g;
      ++count;
    }
  }
  const double mean = static_cast<double>(sum) / count;
  *level = mean;
  *noise = std::sqrt(std::max(0.0, static_cast<double>(squares) / count - mean * mean));
}

// Level of the ring as the median of samples half way between its edges; false when the ring is not
// whole where the image shows it.
bool ReadRing(const Rising& rising, const Moments& moments, double disc, double tolerance,
              double* level) noexcept {
  const Matrix2d root = (4.0 * moments.covariance).llt().matrixL();
  std::array<int, kRingSamples> samples{};
  int count = 0;
  for (int i = 0; i < kRingSamples; ++i) {
    const double angle = 2.0 * kPi * i / kRingSamples;
    const Vector2d p = moments.mean + 1.5 * (root * Vector2d(std::cos(angle), std::sin(angle)));
    const int u = static_cast<int>(std::lround(p.x()));
    const int v = static_cast<int>(std::lround(p.y()));
    if (rising.holds(u, v)) samples[count++] = rising.at(u, v);
  }
  if (count < kRingSamples / 2) return false;
  std::sort(samples.begin(), samples.begin() + count);
  const int median = samples[count / 2];
  const double allowed = tolerance * (disc - median);
  // A second reading of the level from the half of the samples nearest to the median: less noise.
  double sum = 0.0;
  int used = 0;
  for (int i = count / 4; i < count - count / 4; ++i, ++used) sum += samples[i];
  *level = sum / used;
  return median - samples[0] <= allowed && samples[count - 1] - median <= allowed;
}

}  // namespace

const char* Name(MarkerFault fault) noexcept {
  switch (fault) {
    case MarkerFault::kNone:
      return "NONE";
    case MarkerFault::kNotExpected:
      return "NOT_EXPECTED";
    case MarkerFault::kNoContrast:
      return "NO_CONTRAST";
    case MarkerFault::kTooSmall:
      return "TOO_SMALL";
    case MarkerFault::kTooLarge:
      return "TOO_LARGE";
    case MarkerFault::kTouchesWindow:
      return "TOUCHES_WINDOW";
    case MarkerFault::kTouchesBorder:
      return "TOUCHES_BORDER";
    case MarkerFault::kNotElliptic:
      return "NOT_ELLIPTIC";
    case MarkerFault::kWeakRing:
      return "WEAK_RING";
    case MarkerFault::kWrongArea:
      return "WRONG_AREA";
    case MarkerFault::kAmbiguous:
      return "AMBIGUOUS";
    case MarkerFault::kNotFound:
      return "NOT_FOUND";
  }
  return "UNKNOWN";
}

DiscBlob MeasureDisc(const GreyView& image, const PixelWindow& search, int u, int v, bool dark,
                     const DiscOptions& options) noexcept {
  DiscBlob blob;
  const Rising rising{image, Clip(search, image.width, image.height), dark ? 255 : 0};
  if (!rising.holds(u, v)) return blob;
  const int drop = static_cast<int>(0.6 * options.min_contrast);
  const int reach = 2 * static_cast<int>(std::ceil(options.max_semi_axis)) + 1;
  // The mean is less noisy, the pixel itself is still the disc's in small ones.
  const int start = std::max(rising.at(u, v), LevelAround(rising, u, v));

  Levels levels;
  Levels down;
  if (!LevelsAlong(rising, u, v, true, start, drop, reach, &levels, &blob.fault) ||
      !LevelsAlong(rising, u, v, false, start, drop, reach, &down, &blob.fault)) {
    return blob;
  }
  levels = {0.5 * (levels.disc + down.disc), 0.5 * (levels.ring + down.ring)};
  blob.contrast = levels.contrast();
  if (!(blob.contrast >= options.min_contrast)) {
    blob.fault = MarkerFault::kNoContrast;
    return blob;
  }

  Runs runs;
  Fill(rising, u, v, static_cast<int>(0.5 * (levels.disc + levels.ring)), reach, &runs);
  if (runs.fault != MarkerFault::kNone) {
    blob.fault = runs.fault;
    return blob;
  }
  const Moments binary = BinaryMoments(runs);
  // Half a pixel of each pixel's own extent belongs to the shape.
  const Vector2d rough = SemiAxes(4.0 * (binary.covariance + Matrix2d::Identity() / 12.0));
  if (rough.x() < 0.7 * options.min_semi_axis || binary.area < 4.0) {
    blob.fault = MarkerFault::kTooSmall;
    return blob;
  }
  double noise = 0.0;
  ReadInside(rising, runs, &levels.disc, &noise);
  if (!ReadRing(rising, binary, levels.disc, options.ring_tolerance, &levels.ring)) {
    blob.fault = MarkerFault::kWeakRing;
    return blob;
  }
  blob.contrast = levels.contrast();
  if (!(blob.contrast >= options.min_contrast)) {
    blob.fault = MarkerFault::kNoContrast;
    return blob;
  }

  // Cut off what noise does to pixels that are wholly disc or wholly ring.
  const double trim = std::clamp(2.5 * noise / blob.contrast, 0.02, 0.2);
  const int margin = std::clamp(static_cast<int>(std::lround(0.4 * rough.x())), 1, 3);
  const Moments moments = WeightedMoments(rising, runs, margin, levels, trim);
  const Vector2d seen_axes = SemiAxes(4.0 * moments.covariance);
  // An edge blurred by s px makes the sum of w (1 - w) grow by s/√π per pixel of perimeter, and adds s²
  // to the variances. A pixel's own extent is such a blur (s² = 1/12).
  const double blur = std::sqrt(kPi) * moments.edge / std::max(1.0, Perimeter(seen_axes));
  const Matrix2d covariance = moments.covariance - blur * blur * Matrix2d::Identity();
  blob.centroid = moments.mean;
  blob.area = moments.area;
  blob.shape = 4.0 * covariance;

  int left = runs.rows[0].left;
  int right = runs.rows[0].right;
  for (int i = 1; i < runs.count; ++i) {
    left = std::min(left, runs.rows[i].left);
    right = std::max(right, runs.rows[i].right);
  }
  blob.bounds = {left, runs.top, right - left + 1, runs.count};
  if (left < options.border || runs.top < options.border ||
      right > image.width - 1 - options.border ||
      runs.top + runs.count > image.height - options.border) {
    blob.fault = MarkerFault::kTouchesBorder;
    return blob;
  }
  const Vector2d axes = SemiAxes(blob.shape);
  const double determinant = covariance.determinant();
  if (!(determinant > 0.0) || axes.x() < options.min_semi_axis) {
    blob.fault = MarkerFault::kTooSmall;
    return blob;
  }
  if (axes.y() > options.max_semi_axis) {
    blob.fault = MarkerFault::kTooLarge;
    return blob;
  }
  blob.roundness = blob.area / (4.0 * kPi * std::sqrt(determinant));
  blob.skewness = moments.skewness;
  const bool elliptic =
      std::abs(blob.roundness - 1.0) <=
          options.ellipse_tolerance + options.ellipse_slack / blob.area &&
      blob.skewness <= options.skewness_tolerance + options.skewness_slack / blob.area;
  blob.fault = elliptic ? MarkerFault::kNone : MarkerFault::kNotElliptic;
  return blob;
}

}  // namespace vantage
