#include <set>
#include <string>

#include "vantage/config/loaders.h"

namespace vantage {
namespace {

// A kind as files name it, with the points it takes.
struct KindForm {
  std::string name;
  std::vector<FeatureKind> kinds;  // Rows made of it; two for both coordinates at once.
  PointCount points;
  bool each;  // One feature for each point named.
};

KindForm SingleForm(FeatureKind kind) {
  if (kind == FeatureKind::kPointX || kind == FeatureKind::kPointY) {
    return {NameOf(kind), {kind}, {1, kMaxPoints}, true};
  }
  return {NameOf(kind), {kind}, PointsOf(kind), false};
}

const std::vector<KindForm>& KindForms() {
  static const std::vector<KindForm> forms = [] {
    std::vector<KindForm> all{
        {"point", {FeatureKind::kPointX, FeatureKind::kPointY}, {1, kMaxPoints}, true},
        {"centroid",
         {FeatureKind::kCentroidX, FeatureKind::kCentroidY},
         PointsOf(FeatureKind::kCentroidX),
         false}};
    for (const FeatureKind kind : AllFeatureKinds()) all.push_back(SingleForm(kind));
    return all;
  }();
  return forms;
}

Section::Names<int> KindNames() {
  Section::Names<int> names;
  for (const KindForm& form : KindForms())
    names.emplace_back(form.name, static_cast<int>(names.size()));
  return names;
}

// What a kind asks for besides its points.
Feature LoadParameters(const Section& section, FeatureKind kind) {
  Feature feature;
  feature.kind = kind;
  if (kind == FeatureKind::kMomentBasic || kind == FeatureKind::kMomentCentred) {
    feature.order_x = static_cast<int>(section.Integer("order_x", 0, 3, kRequired, "Order in u."));
    feature.order_y = static_cast<int>(section.Integer("order_y", 0, 3, kRequired, "Order in v."));
  }
  if (kind == FeatureKind::kMomentAreaNormalised || kind == FeatureKind::kMomentXNormalised ||
      kind == FeatureKind::kMomentYNormalised) {
    feature.desired_area = section.Number("desired_area", {1e-6, 1e12, "px^2"}, kRequired,
                                          "Area at the desired depth.");
    feature.desired_depth =
        section.Number("desired_depth", {1e-3, 1e4, "m"}, kRequired, "Depth of the goal.");
  }
  return feature;
}

void AppendRows(const KindForm& form, const Section& section, const std::vector<int>& points,
                std::vector<Feature>* features) {
  for (const FeatureKind kind : form.kinds) {
    const Feature parameters = LoadParameters(section, kind);
    if (!form.each) {
      features->push_back(parameters);
      features->back().points = points;
    }
  }
  if (!form.each) return;
  for (const int point : points) {
    for (const FeatureKind kind : form.kinds) {
      features->push_back({});
      features->back().kind = kind;
      features->back().points = {point};
    }
  }
}

}  // namespace

std::vector<Feature> LoadFeatures(const Section& parent, const std::string& key, int num_points) {
  const std::string help =
      "What the servo controls: all_points (both coordinates of each marker), or a list.";
  std::vector<Feature> features;
  if (parent.FormOf(key) == Section::Form::kScalar) {
    (void)parent.Choice<int>(key, {{"all_points", 0}}, kRequired, help);
    return FeatureSet::AllPoints(num_points).features();
  }
  for (const Section& section : parent.Children(key, 1, kMaxRows, help)) {
    const KindForm& form = KindForms()[section.Choice<int>(
        "kind", KindNames(), kRequired,
        "What is measured of the points; point, point_x and point_y give rows for each of them.")];
    const std::vector<std::int64_t> indices =
        section.Integers("points", 0, num_points - 1, form.points.least, form.points.most,
                         "Markers of the end effector, counted from 0 in their list's order.");
    std::vector<int> points(indices.begin(), indices.end());
    if (std::set<int>(points.begin(), points.end()).size() != points.size() &&
        form.kinds[0] != FeatureKind::kEdgeAngle) {
      section.Fail("points", "must not name a point twice");
    }
    AppendRows(form, section, points, &features);
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
