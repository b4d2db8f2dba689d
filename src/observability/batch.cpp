#include "vantage/observability/batch.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include <Eigen/SVD>

#include "batch_data.h"
#include "batch_kernels.h"
#include "vantage/camera/pinhole.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using batch::kCameraFields;
using batch::kPadding;
using batch::Padded;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const batch::KernelTable& TableOf(BatchIsa isa) {
#ifdef VANTAGE_BATCH_X86
  if (isa == BatchIsa::kAvx512) return batch::Avx512Kernels();
  if (isa == BatchIsa::kAvx2) return batch::Avx2Kernels();
#endif
  (void)isa;
  return batch::BaselineKernels();
}

template <class T>
const batch::Kernels<T>& KernelsOf(BatchIsa isa);
template <>
const batch::Kernels<double>& KernelsOf<double>(BatchIsa isa) {
  return TableOf(isa).f64;
}
template <>
const batch::Kernels<float>& KernelsOf<float>(BatchIsa isa) {
  return TableOf(isa).f32;
}

batch::Quantity QuantityOf(BatchMeasure measure) {
  switch (measure) {
    case BatchMeasure::kW:
      return batch::Quantity::kW;
    case BatchMeasure::kLogW:
      return batch::Quantity::kLogW;
    case BatchMeasure::kSigmaMin:
      return batch::Quantity::kSigmaMin;
    case BatchMeasure::kInverseCondition:
      return batch::Quantity::kInverseCondition;
    case BatchMeasure::kNegativeTrace:
      break;
  }
  return batch::Quantity::kNegativeTrace;
}

bool NeedsSingularValues(BatchMeasure measure) {
  return measure != BatchMeasure::kW && measure != BatchMeasure::kLogW;
}

// The kernels work with fy = 1; what the measure gains by it, as factor and as addend per unit of weight.
struct FocalShare {
  double factor{1.0};
  double addend{0.0};
};
FocalShare FocalShareOf(BatchMeasure measure, double fy, int rank) {
  switch (measure) {
    case BatchMeasure::kW:
      return {std::pow(fy, rank), 0.0};
    case BatchMeasure::kLogW:
      return {1.0, rank * std::log(fy)};
    case BatchMeasure::kSigmaMin:
      return {fy, 0.0};
    case BatchMeasure::kInverseCondition:
      return {1.0, 0.0};
    case BatchMeasure::kNegativeTrace:
      break;
  }
  return {1.0 / (fy * fy), 0.0};
}

template <class T>
batch::Lens<T> LensOf(const BatchLens& lens) {
  return {static_cast<T>(lens.fx / lens.fy),
          static_cast<T>(lens.skew / lens.fy),
          static_cast<T>(0.5 * (lens.x_min + lens.x_max)),
          static_cast<T>(0.5 * (lens.x_max - lens.x_min)),
          static_cast<T>(0.5 * (lens.y_min + lens.y_max)),
          static_cast<T>(0.5 * (lens.y_max - lens.y_min))};
}

// Cameras [first, first + count) as the kernels of one precision read them. Those of double precision are
// read in place.
template <class T>
class CameraBlock;

template <>
class CameraBlock<double> {
 public:
  CameraBlock(const BatchCameras& cameras, int first, int count, const Vector3d&, double) {
    for (int f = 0; f < kCameraFields; ++f) view_.field[f] = cameras.field(f) + first;
    view_.count = count;
  }
  const batch::CamerasView<double>& view() const { return view_; }

 private:
  batch::CamerasView<double> view_{};
};

template <>
class CameraBlock<float> {
 public:
  CameraBlock(const BatchCameras& cameras, int first, int count, const Vector3d& origin,
              double unit) {
    const int stride = Padded(count);
    data_.resize(static_cast<std::size_t>(kCameraFields) * stride);
    for (int f = 0; f < kCameraFields; ++f) {
      const bool centre = f >= 9 && f < 12;
      const double shift = centre ? origin(f - 9) : 0.0;
      const double scale = centre ? 1.0 / unit : 1.0;
      const double* from = cameras.field(f) + first;
      float* to = data_.data() + static_cast<std::size_t>(f) * stride;
      for (int i = 0; i < stride; ++i) to[i] = static_cast<float>((from[i] - shift) * scale);
      view_.field[f] = to;
    }
    view_.count = count;
  }
  const batch::CamerasView<float>& view() const { return view_; }

 private:
  batch::CamerasView<float> view_{};
  std::vector<float> data_;
};

// Output arrays of one precision, copied to the caller's with a factor and an addend.
template <class T>
class Output {
 public:
  explicit Output(int count) : count_(count) {
    if (count > kFew) many_.resize(Padded(count));
  }
  T* data() { return count_ > kFew ? many_.data() : few_; }
  void CopyTo(std::vector<double>* out, double factor, double addend) {
    const T* from = data();
    out->resize(count_);
    for (int i = 0; i < count_; ++i) (*out)[i] = factor * static_cast<double>(from[i]) + addend;
  }

 private:
  static constexpr int kFew = 6 * batch::kPadding;  // no more of them cost an allocation
  int count_;
  T few_[kFew];  // the kernels write before it is read
  std::vector<T> many_;
};

template <class T>
const batch::SceneView<T>& ViewOf(const batch::PackedForm& form);
template <>
const batch::SceneView<double>& ViewOf<double>(const batch::PackedForm& form) {
  return form.f64.view;
}
template <>
const batch::SceneView<float>& ViewOf<float>(const batch::PackedForm& form) {
  return form.f32.view;
}

template <class T>
void ScoreIn(BatchIsa isa, const BatchScene::Data& data, const BatchCameras& cameras, int first,
             int count, const BatchLens& lens, BatchMeasure measure, bool with_least,
             BatchScores* scores) {
  const batch::PackedForm& form = NeedsSingularValues(measure) ? data.Generic() : data.form;
  const CameraBlock<T> block(cameras, first, count, data.origin, data.unit);
  Output<T> sum(count), least(count);
  batch::ValueOutput<T> out{sum.data(), with_least ? least.data() : nullptr};
  KernelsOf<T>(isa).value(ViewOf<T>(form), block.view(), LensOf<T>(lens), QuantityOf(measure), out);
  const FocalShare share = FocalShareOf(measure, lens.fy, data.rank);
  sum.CopyTo(&scores->sum, share.factor, share.addend * data.total_weight);
  if (with_least) least.CopyTo(&scores->least, share.factor, share.addend);
}

template <class T>
void CheckFrustumIn(BatchIsa isa, const BatchScene::Data& data, batch::HullView<T> hull,
                    double unit, const BatchCameras& cameras, int first, int count,
                    const BatchLens& lens, const DepthLimits& limits, double least_image,
                    BatchMargins* margins) {
  const CameraBlock<T> block(cameras, first, count, data.origin, data.unit);
  Output<T> near(count), far(count), image(count);
  hull.min_depth = static_cast<T>(limits.min / unit);
  hull.max_depth = static_cast<T>(limits.max / unit);
  hull.least_image = static_cast<T>(least_image / unit);
  KernelsOf<T>(isa).frustum(hull, block.view(), LensOf<T>(lens),
                            {near.data(), far.data(), image.data()});
  near.CopyTo(&margins->near, unit, 0.0);
  far.CopyTo(&margins->far, unit, 0.0);
  image.CopyTo(&margins->image, unit, 0.0);
}

template <class T>
void CheckObstaclesIn(BatchIsa isa, const BatchObstacles::Data& data,
                      const batch::PackedObstacles<T>& packed, double unit,
                      const BatchCameras& cameras, int first, int count, BatchMargins* margins) {
  const CameraBlock<T> block(cameras, first, count, data.origin, data.unit);
  Output<T> occlusion(count), facing(count);
  KernelsOf<T>(isa).obstacles(packed.view, block.view(), {occlusion.data(), facing.data()});
  occlusion.CopyTo(&margins->occlusion, unit, 0.0);
  facing.CopyTo(&margins->facing, unit, 0.0);
}

// Rows of J_c and, when asked for, their derivatives by the camera's twist.
struct PlainRows {
  MatrixXd J;                     // k×n
  std::array<MatrixXd, 6> slope;  // dJ by (v, ω)
};

PlainRows RowsOf(const BatchScene& scene, const BatchSample& sample, const Eigen::Isometry3d& X_WC,
                 double zoom, const BatchLens& lens, bool with_slope) {
  const std::vector<BatchRow>& rows = scene.rows();
  const auto k = static_cast<Eigen::Index>(rows.size());
  const int n = scene.joints();
  PlainRows result;
  result.J.resize(k, n);
  if (with_slope) result.slope.fill(MatrixXd::Zero(k, n));
  const Matrix3d R_CW = X_WC.linear().transpose();
  Eigen::Matrix2d K;
  K << lens.fx, lens.skew, 0.0, lens.fy;
  K *= zoom;
  for (Eigen::Index row = 0; row < k; ++row) {
    const int point = rows[row].point;
    const Vector3d p = R_CW * (sample.p_W[point] - X_WC.translation());
    if (!(p.z() > kMinDepth)) {
      result.J.row(row).setConstant(kNaN);
      continue;
    }
    const MatrixXd A = R_CW * sample.J_p_W[point];  // in camera axes
    // Row of K/Z [1 0 -x; 0 1 -y], and its derivative by p.
    const Eigen::RowVector2d in_pixels = K.row(rows[row].axis);
    Eigen::Matrix<double, 2, 3> D;
    D << 1.0, 0.0, -p.x() / p.z(), 0.0, 1.0, -p.y() / p.z();
    D /= p.z();
    const Eigen::RowVector3d g = in_pixels * D;
    result.J.row(row) = g * A;
    if (!with_slope) continue;
    for (int i = 0; i < 6; ++i) {
      // dp = -(v + ω × p); the derivatives of the point turn with the axes: dA = -ω × A.
      const Vector3d unit = Vector3d::Unit(i % 3);
      const Vector3d dp = i < 3 ? Vector3d(-unit) : Vector3d(-unit.cross(p));
      Eigen::Matrix<double, 2, 3> dD = -D * (dp.z() / p.z());
      const Eigen::Vector2d dn = D * dp;
      dD.col(2) -= dn / p.z();
      result.slope[i].row(row) = in_pixels * dD * A;
      if (i >= 3) result.slope[i].row(row) -= g * Skew(unit) * A;
    }
  }
  return result;
}

// w from the s largest singular values, and dw = w Σ u_iᵀ dJ v_i / σ_i.
void PlainProfile(const BatchScene& scene, const Eigen::Isometry3d& X_WC, double zoom,
                  const BatchLens& lens, BatchProfile* profile) {
  const auto N = static_cast<Eigen::Index>(scene.samples().size());
  profile->w.assign(N, 0.0);
  profile->gradient.setZero(6, N);
  for (Eigen::Index i = 0; i < N; ++i) {
    const PlainRows rows = RowsOf(scene, scene.samples()[i], X_WC, zoom, lens, true);
    if (!rows.J.allFinite()) continue;
    const Eigen::JacobiSVD<MatrixXd> svd(rows.J, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const int s = scene.rank();
    const double w = svd.singularValues().head(s).prod();
    profile->w[i] = w;
    if (!(w > 0.0)) continue;
    for (int j = 0; j < 6; ++j) {
      double slope = 0.0;
      for (int k = 0; k < s; ++k) {
        slope += svd.matrixU().col(k).dot(rows.slope[j] * svd.matrixV().col(k)) /
                 svd.singularValues()(k);
      }
      profile->gradient(j, i) = w * slope;
    }
  }
}

}  // namespace

BatchLens BatchLens::FromCamera(const CameraModel& camera, double margin) {
  BatchLens lens;
  lens.fx = camera.fx;
  lens.fy = camera.fy;
  lens.skew = camera.skew;
  // The border of the image, lens undone, is curved (skew makes it oblique): keep the rectangle inside.
  constexpr int kSteps = 64;
  const double left = margin, right = camera.width - 1.0 - margin;
  const double top = margin, bottom = camera.height - 1.0 - margin;
  lens.x_min = lens.y_min = -std::numeric_limits<double>::infinity();
  lens.x_max = lens.y_max = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    const double u = left + (right - left) * i / kSteps;
    const double v = top + (bottom - top) * i / kSteps;
    lens.x_min = std::max(lens.x_min, ToNormalised(camera, {left, v}).x());
    lens.x_max = std::min(lens.x_max, ToNormalised(camera, {right, v}).x());
    lens.y_min = std::max(lens.y_min, ToNormalised(camera, {u, top}).y());
    lens.y_max = std::min(lens.y_max, ToNormalised(camera, {u, bottom}).y());
  }
  if (!(lens.x_min < lens.x_max) || !(lens.y_min < lens.y_max)) {
    throw ConfigError("", "batch.margin",
                      "must leave some of the image, is " + std::to_string(margin) + " px");
  }
  return lens;
}

void BatchCameras::Resize(int count) {
  assert(count >= 0);
  count_ = count;
  // A block may start at any camera and reads up to kPadding entries past the last.
  const int stride = Padded(count) + kPadding;
  if (stride > stride_) {
    stride_ = stride;
    data_.assign(static_cast<std::size_t>(kCameraFields) * stride_, 1.0);
  }
}

void BatchCameras::Set(int i, const Eigen::Isometry3d& X_WC, double zoom) noexcept {
  assert(i >= 0 && i < count_);
  double* entry = data_.data() + i;
  const Matrix3d& R_WC = X_WC.linear();
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) entry[(3 * axis + k) * stride_] = R_WC(k, axis);
  }
  entry[batch::kZoomField * stride_] = zoom;
  Move(i, X_WC.translation());
}

void BatchCameras::Turn(const BatchCameras& from, const std::vector<int>& source) {
  Resize(static_cast<int>(source.size()));
  for (int f = 0; f < kCameraFields; ++f) {
    if (f >= 9 && f < 12) continue;
    const double* of = from.field(f);
    double* entry = data_.data() + f * stride_;
    for (std::size_t i = 0; i < source.size(); ++i) entry[i] = of[source[i]];
  }
}

void BatchCameras::Move(int i, const Vector3d& p_WC) noexcept {
  assert(i >= 0 && i < count_);
  for (int axis = 0; axis < 3; ++axis) data_[(9 + axis) * stride_ + i] = p_WC(axis);
}

BatchEvaluator::BatchEvaluator() : isa_(AvailableIsas().back()) {}

BatchEvaluator::BatchEvaluator(BatchIsa isa) : isa_(isa) {
  const std::vector<BatchIsa> available = AvailableIsas();
  if (std::find(available.begin(), available.end(), isa) == available.end()) {
    throw ConfigError("", "batch.isa", "must be one this machine runs, is " + Name(isa));
  }
}

int BatchEvaluator::lanes(BatchPrecision precision) const noexcept {
  const batch::KernelTable& table = TableOf(isa_);
  return precision == BatchPrecision::kDouble ? table.f64.lanes : table.f32.lanes;
}

void BatchEvaluator::Score(const BatchScene& scene, const BatchCameras& cameras, int first,
                           int count, const BatchLens& lens, BatchMeasure measure,
                           BatchPrecision precision, bool with_least, BatchScores* scores) const {
  assert(first >= 0 && first + count <= cameras.size());
  const auto score = precision == BatchPrecision::kDouble ? &ScoreIn<double> : &ScoreIn<float>;
  score(isa_, scene.data(), cameras, first, count, lens, measure, with_least, scores);
}

void BatchEvaluator::CheckFrustum(const BatchScene& scene, const BatchCameras& cameras, int first,
                                  int count, const BatchLens& lens, const DepthLimits& limits,
                                  BatchPrecision precision, BatchMargins* margins,
                                  double least_image) const {
  assert(first >= 0 && first + count <= cameras.size());
  const BatchScene::Data& data = scene.data();
  if (precision == BatchPrecision::kDouble) {
    CheckFrustumIn<double>(isa_, data, data.hull64.view, 1.0, cameras, first, count, lens, limits,
                           least_image, margins);
  } else {
    CheckFrustumIn<float>(isa_, data, data.hull32.view, data.unit, cameras, first, count, lens,
                          limits, least_image, margins);
  }
}

void BatchEvaluator::CheckObstacles(const BatchObstacles& obstacles, const BatchCameras& cameras,
                                    int first, int count, BatchPrecision precision,
                                    BatchMargins* margins) const {
  assert(first >= 0 && first + count <= cameras.size());
  const BatchObstacles::Data& data = obstacles.data();
  if (precision == BatchPrecision::kDouble) {
    CheckObstaclesIn<double>(isa_, data, data.f64, 1.0, cameras, first, count, margins);
  } else {
    CheckObstaclesIn<float>(isa_, data, data.f32, data.unit, cameras, first, count, margins);
  }
}

void BatchEvaluator::Profile(const BatchScene& scene, const Eigen::Isometry3d& X_WC, double zoom,
                             const BatchLens& lens, bool with_gradient,
                             BatchProfile* profile) const {
  const BatchScene::Data& data = scene.data();
  const batch::SceneView<double>& view = data.form.f64.view;
  if (with_gradient && view.family == batch::Family::kGeneric) {
    PlainProfile(scene, X_WC, zoom, lens, profile);
    return;
  }
  BatchCameras camera;
  camera.Resize(1);
  camera.Set(0, X_WC, zoom);
  const CameraBlock<double> block(camera, 0, 1, data.origin, data.unit);

  const int N = view.samples, padded = view.padded;
  std::vector<double> w(padded), slopes(with_gradient ? 6 * padded : 0);
  KernelsOf<double>(isa_).profile(view, block.view(), LensOf<double>(lens),
                                  {w.data(), with_gradient ? slopes.data() : nullptr});
  const double factor = std::pow(lens.fy, data.rank);
  profile->w.resize(N);
  for (int i = 0; i < N; ++i) profile->w[i] = factor * w[i];
  profile->gradient.resize(6, with_gradient ? N : 0);
  if (!with_gradient) return;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < N; ++i) profile->gradient(j, i) = factor * slopes[j * padded + i];
  }
}

MatrixXd PlainJacobian(const BatchScene& scene, int sample, const Eigen::Isometry3d& X_WC,
                       double zoom, const BatchLens& lens) {
  return RowsOf(scene, scene.samples()[sample], X_WC, zoom, lens, false).J;
}

}  // namespace vantage
