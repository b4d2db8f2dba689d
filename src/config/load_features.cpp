#include <set>

#include "vantage/config/loaders.h"

namespace vantage {
namespace {

// A kind as files name it, with the points it takes.
struct KindForm {
  std::vector<FeatureKind> kinds;  // Rows made of it; two for both coordinates at once.
  int min_points;
  int max_points;
  bool each;  // One feature for each point named.
};

const Section::Names<int> kKindNames{
    {"point", 0},      {"point_x", 1}, {"point_y", 2},  {"distance", 3},   {"angle", 4},
    {"edge_angle", 5}, {"area", 6},    {"centroid", 7}, {"centroid_x", 8}, {"centroid_y", 9}};

const std::vector<KindForm>& KindForms() {
  static const std::vector<KindForm> forms{
      {{FeatureKind::kPointX, FeatureKind::kPointY}, 1, kMaxPoints, true},
      {{FeatureKind::kPointX}, 1, kMaxPoints, true},
      {{FeatureKind::kPointY}, 1, kMaxPoints, true},
      {{FeatureKind::kDistance}, 2, 2, false},
      {{FeatureKind::kAngle}, 2, 2, false},
      {{FeatureKind::kEdgeAngle}, 4, 4, false},
      {{FeatureKind::kArea}, 3, kMaxPoints, false},
      {{FeatureKind::kCentroidX, FeatureKind::kCentroidY}, 1, kMaxPoints, false},
      {{FeatureKind::kCentroidX}, 1, kMaxPoints, false},
      {{FeatureKind::kCentroidY}, 1, kMaxPoints, false}};
  return forms;
}

void AppendRows(const KindForm& form, const std::vector<int>& points,
                std::vector<Feature>* features) {
  if (form.each) {
    for (const int point : points) {
      for (const FeatureKind kind : form.kinds) features->push_back({kind, {point}});
    }
    return;
  }
  for (const FeatureKind kind : form.kinds) features->push_back({kind, points});
}

}  // namespace

std::vector<Feature> LoadFeatures(const Section& parent, const std::string& key, int num_points) {
  const std::string help =
      "What the servo controls: all_points (both coordinates of each marker), or a list.";
  std::vector<Feature> features;
  if (parent.FormOf(key) == Section::Form::kScalar) {
    (void)parent.Choice<int>(key, {{"all_points", 0}}, kRequired, help);
    for (int i = 0; i < num_points; ++i) AppendRows(KindForms()[0], {i}, &features);
    return features;
  }
  for (const Section& section : parent.Children(key, 1, kMaxRows, help)) {
    const KindForm& form = KindForms()[section.Choice<int>(
        "kind", kKindNames, kRequired,
        "What is measured of the points; point, point_x and point_y give rows for each of them.")];
    const std::vector<std::int64_t> indices =
        section.Integers("points", 0, num_points - 1, form.min_points, form.max_points,
                         "Markers of the end effector, counted from 0 in their list's order.");
    std::vector<int> points(indices.begin(), indices.end());
    if (std::set<int>(points.begin(), points.end()).size() != points.size() &&
        form.kinds[0] != FeatureKind::kEdgeAngle) {
      section.Fail("points", "must not name a point twice");
    }
    AppendRows(form, points, &features);
  }
  if (features.size() > static_cast<std::size_t>(kMaxRows)) {
    parent.Fail(key, "must give at most " + std::to_string(kMaxRows) + " rows, give " +
                         std::to_string(features.size()));
  }
  return features;
}

std::vector<Marker> LoadMarkers(const Section& parent, const std::string& key, int min_count,
                                int max_count, const std::string& help) {
  std::vector<Marker> markers;
  std::set<int> ids;
  for (const Section& section : parent.Children(key, min_count, max_count, help)) {
    Marker marker;
    marker.id = static_cast<int>(section.Integer("id", 0, 1000000, kRequired, "Unique number."));
    if (!ids.insert(marker.id).second) {
      section.Fail("id", std::to_string(marker.id) + " names two markers");
    }
    marker.p = section.Vector3("position", {-1000.0, 1000.0, "m"}, kRequired,
                               "Centre, in the frame it is fixed to.");
    const Eigen::Vector3d normal =
        section.Vector3("normal", {-1000.0, 1000.0, ""}, Eigen::Vector3d(0, 0, 1),
                        "The side it is seen from; need not have length 1.");
    if (!(normal.norm() > 1e-3)) section.Fail("normal", "must not be zero");
    marker.normal = normal.normalized();
    marker.radius = section.Number("radius", {1e-4, 10.0, "m"}, marker.radius,
                                   "Of the disc; its ring has twice the radius.");
    marker.dark = section.Flag("dark", marker.dark, "Dark disc on a bright ring, or the reverse.");
    markers.push_back(marker);
  }
  return markers;
}

}  // namespace vantage
