#include <array>

#include "feature_forms.h"
#include "vantage/features/feature_set.h"

namespace vantage {
namespace {

struct KindForm {
  FeatureKind kind;
  const char* name;
  PointCount points;
};

constexpr int kAny = kMaxPoints;

// In the order of the enumeration.
constexpr std::array kForms{
    KindForm{FeatureKind::kPointX, "point_x", {1, 1}},
    KindForm{FeatureKind::kPointY, "point_y", {1, 1}},
    KindForm{FeatureKind::kDistance, "distance", {2, 2}},
    KindForm{FeatureKind::kAngle, "angle", {2, 2}},
    KindForm{FeatureKind::kEdgeAngle, "edge_angle", {4, 4}},
    KindForm{FeatureKind::kArea, "area", {3, kAny}},
    KindForm{FeatureKind::kCentroidX, "centroid_x", {1, kAny}},
    KindForm{FeatureKind::kCentroidY, "centroid_y", {1, kAny}},
    KindForm{FeatureKind::kSegmentX, "segment_x", {2, 2}},
    KindForm{FeatureKind::kSegmentY, "segment_y", {2, 2}},
    KindForm{FeatureKind::kSegmentLength, "segment_length", {2, 2}},
    KindForm{FeatureKind::kSegmentAngle, "segment_angle", {2, 2}},
    KindForm{FeatureKind::kSegmentXNormalised, "segment_x_normalised", {2, 2}},
    KindForm{FeatureKind::kSegmentYNormalised, "segment_y_normalised", {2, 2}},
    KindForm{FeatureKind::kSegmentInverseLength, "segment_inverse_length", {2, 2}},
    KindForm{FeatureKind::kMomentBasic, "moment_basic", {1, kAny}},
    KindForm{FeatureKind::kMomentCentred, "moment_centred", {2, kAny}},
    KindForm{FeatureKind::kMomentX, "moment_x", {1, kAny}},
    KindForm{FeatureKind::kMomentY, "moment_y", {1, kAny}},
    KindForm{FeatureKind::kMomentArea, "moment_area", {2, kAny}},
    KindForm{FeatureKind::kMomentAreaNormalised, "moment_area_normalised", {2, kAny}},
    KindForm{FeatureKind::kMomentXNormalised, "moment_x_normalised", {2, kAny}},
    KindForm{FeatureKind::kMomentYNormalised, "moment_y_normalised", {2, kAny}},
    KindForm{FeatureKind::kMomentAlpha, "moment_alpha", {2, kAny}},
};

constexpr bool IsInOrder() {
  for (std::size_t i = 0; i < kForms.size(); ++i) {
    if (kForms[i].kind != static_cast<FeatureKind>(i)) return false;
  }
  return true;
}
static_assert(IsInOrder());

const KindForm* FormOf(FeatureKind kind) noexcept {
  const auto i = static_cast<std::size_t>(kind);
  return i < kForms.size() ? &kForms[i] : nullptr;
}

}  // namespace

const char* NameOf(FeatureKind kind) noexcept {
  const KindForm* form = FormOf(kind);
  return form != nullptr ? form->name : "";
}

PointCount PointsOf(FeatureKind kind) noexcept {
  const KindForm* form = FormOf(kind);
  return form != nullptr ? form->points : PointCount{1, 0};
}

const std::vector<FeatureKind>& AllFeatureKinds() {
  static const std::vector<FeatureKind> kinds = [] {
    std::vector<FeatureKind> all;
    for (const KindForm& form : kForms) all.push_back(form.kind);
    return all;
  }();
  return kinds;
}

bool IsSegment(FeatureKind kind) noexcept {
  return kind >= FeatureKind::kSegmentX && kind <= FeatureKind::kSegmentInverseLength;
}

bool IsPair(FeatureKind kind) noexcept {
  return kind == FeatureKind::kDistance || kind == FeatureKind::kAngle || IsSegment(kind);
}

bool IsMoment(FeatureKind kind) noexcept {
  return kind >= FeatureKind::kMomentBasic && kind <= FeatureKind::kMomentAlpha;
}

bool IsMadeOfMoments(FeatureKind kind) noexcept {
  return IsMoment(kind) && kind != FeatureKind::kMomentBasic && kind != FeatureKind::kMomentCentred;
}

}  // namespace vantage
