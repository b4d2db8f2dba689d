#pragma once

#include <mutex>
#include <vector>

#include "batch_kernels.h"
#include "vantage/observability/batch.h"

/// @file
/// What the batch evaluator's values hold, for its own translation units.

namespace vantage {

namespace batch {

/// `count` rounded up to a multiple of kPadding.
constexpr int Padded(int count) noexcept {
  return (count + kPadding - 1) / kPadding * kPadding;
}

/// Records of one form in one precision, with the memory behind the view.
template <class T>
struct PackedScene {
  SceneView<T> view{};
  std::vector<T> record, lanes, weight, weighted;
};

template <class T>
struct PackedHull {
  std::vector<T> node, xyz;
  std::vector<Chain<T>> chain;
  HullView<T> view{};
};

/// Both precisions of one form.
struct PackedForm {
  PackedScene<double> f64;
  PackedScene<float> f32;
};

template <class T>
struct PackedObstacles {
  std::vector<Sight<T>> sight;
  std::vector<CapsuleTest<T>> capsule;
  std::vector<BoxTest<T>> box;
  ObstaclesView<T> view{};
};

}  // namespace batch

struct BatchScene::Data {
  std::vector<BatchSample> samples;
  std::vector<BatchRow> rows;
  BatchBody body{BatchBody::kRigid};
  int points{0}, joints{0}, rank{0};
  double total_weight{0.0};
  Eigen::Vector3d origin{Eigen::Vector3d::Zero()};  ///< Of single precision.
  double unit{1.0};                                 ///< Length of single precision [m].
  batch::Family family{batch::Family::kGeneric};
  batch::PackedForm form;
  /// Records for the measures that need all singular values; made when first asked for.
  mutable batch::PackedForm generic;
  mutable std::once_flag generic_made;
  int hull_count{0};
  batch::PackedHull<double> hull64;
  batch::PackedHull<float> hull32;

  /// The generic form, made if need be.
  const batch::PackedForm& Generic() const;
};

struct BatchObstacles::Data {
  Eigen::Vector3d origin{Eigen::Vector3d::Zero()};
  double unit{1.0};
  batch::PackedObstacles<double> f64;
  batch::PackedObstacles<float> f32;
};

}  // namespace vantage
