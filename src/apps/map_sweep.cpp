#include "map_sweep.h"

#include <atomic>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <limits>
#include <thread>

#include "vantage/math/error.h"

namespace vantage {
namespace {

void Apply(const MapRecipe& recipe, const SweepAxis& axis, double value, JointVector* q,
           RigVector* q_c) {
  switch (axis.kind) {
    case SweepAxis::Kind::kRig:
      (*q_c)(axis.indices[0]) = value;
      return;
    case SweepAxis::Kind::kJoint:
      for (const int joint : axis.indices) (*q)(joint) = value;
      return;
    case SweepAxis::Kind::kPath:
      *q = JointsAlong(recipe.setup.waypoints, value);
      return;
  }
}

std::string WithUnit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " [" + unit + "]";
}

void WriteNumber(std::ofstream* file, std::optional<double> value) {
  *file << ',';
  if (value && std::isfinite(*value)) *file << *value;
}

}  // namespace

MapCell EvaluateCell(const MapRecipe& recipe, double x, double y) {
  JointVector q = recipe.setup.q;
  RigVector q_c = recipe.setup.q_c;
  // A path sets all joints: it comes before what turns single ones.
  const bool y_first = recipe.axes[1].kind == SweepAxis::Kind::kPath;
  for (const int i : {y_first ? 1 : 0, y_first ? 0 : 1}) {
    Apply(recipe, recipe.axes[i], i == 0 ? x : y, &q, &q_c);
  }
  const Measurement m = Evaluate(recipe.setup, q, q_c);
  MapCell cell;
  cell.x = x;
  cell.y = y;
  cell.complete = m.rows.size() == static_cast<int>(recipe.setup.features.features().size());
  cell.w_v = m.view.measure.w;
  cell.w_r = m.arm.measure.w;
  cell.w_c = m.composite.measure.w;
  cell.rank_c = m.composite.measure.rank;
  cell.sigma_min_c = m.composite.measure.sigma_min;
  cell.condition_c = m.composite.measure.condition;
  cell.geometric_mean_c = m.composite.measure.geometric_mean();
  if (m.translation) {
    cell.w_v_translation = m.translation->view.w;
    cell.w_r_translation = m.translation->arm.w;
    cell.paper_product = m.translation->product;
  }
  return cell;
}

MapTable Sweep(const MapRecipe& recipe, const std::function<void(int, int)>& progress) {
  MapTable table;
  table.columns = recipe.axes[0].samples;
  table.rows = recipe.axes[1].samples;
  table.cells.resize(static_cast<std::size_t>(table.columns) * table.rows);
  std::atomic<int> next{0}, done{0};
  const auto work = [&](bool reports) {
    for (int row = next++; row < table.rows; row = next++) {
      const double y = ValueAt(recipe.axes[1], row);
      for (int column = 0; column < table.columns; ++column) {
        table.cells[static_cast<std::size_t>(row) * table.columns + column] =
            EvaluateCell(recipe, ValueAt(recipe.axes[0], column), y);
      }
      const int so_far = ++done;
      if (reports && progress) progress(so_far, table.rows);
    }
  };
  std::vector<std::thread> helpers;
  for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i)
    helpers.emplace_back(work, false);
  work(true);
  for (std::thread& helper : helpers) helper.join();
  return table;
}

std::optional<double> ValueOf(const MapCell& cell, MapQuantity quantity) noexcept {
  if (!cell.complete && quantity != MapQuantity::kArmW) return std::nullopt;
  switch (quantity) {
    case MapQuantity::kViewW:
      return cell.w_v;
    case MapQuantity::kArmW:
      return cell.w_r;
    case MapQuantity::kCompositeW:
      return cell.w_c;
    case MapQuantity::kSigmaMin:
      return cell.sigma_min_c;
    case MapQuantity::kGeometricMean:
      return cell.geometric_mean_c;
    case MapQuantity::kPaperProduct:
      return cell.paper_product;
  }
  return std::nullopt;
}

void WriteCsv(const MapRecipe& recipe, const MapTable& table, const std::string& path) {
  std::ofstream file(path);
  file << WithUnit(recipe.axes[0].name, recipe.axes[0].unit) << ','
       << WithUnit(recipe.axes[1].name, recipe.axes[1].unit)
       << ",w_v,w_r,w_c,rank_c,sigma_min_c,condition_c,geometric_mean_c";
  const bool translation = recipe.setup.translation_task > 0;
  if (translation) file << ",w_v_translation,w_r_translation,paper_product";
  file << '\n' << std::setprecision(17);
  for (const MapCell& cell : table.cells) {
    const auto known = [&](double value) {
      return cell.complete ? std::optional<double>(value) : std::nullopt;
    };
    file << cell.x << ',' << cell.y;
    WriteNumber(&file, known(cell.w_v));
    WriteNumber(&file, cell.w_r);
    WriteNumber(&file, known(cell.w_c));
    WriteNumber(&file, known(cell.rank_c));
    WriteNumber(&file, known(cell.sigma_min_c));
    WriteNumber(&file, known(cell.condition_c));
    WriteNumber(&file, known(cell.geometric_mean_c));
    if (translation) {
      WriteNumber(&file, known(cell.w_v_translation));
      WriteNumber(&file, cell.w_r_translation);
      WriteNumber(&file, known(cell.paper_product));
    }
    file << '\n';
  }
  file.close();
  if (!file) throw WriteError(path);
}

std::optional<MapExtremes> FindExtremes(const MapTable& table, MapQuantity quantity) noexcept {
  std::optional<MapExtremes> extremes;
  for (const MapCell& cell : table.cells) {
    const std::optional<double> value = ValueOf(cell, quantity);
    if (!value) continue;
    if (!extremes) extremes = MapExtremes{*value, *value, cell, cell};
    if (*value < extremes->min) {
      extremes->min = *value;
      extremes->at_min = cell;
    }
    if (*value > extremes->max) {
      extremes->max = *value;
      extremes->at_max = cell;
    }
  }
  return extremes;
}

}  // namespace vantage
