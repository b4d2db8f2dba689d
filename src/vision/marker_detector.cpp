#include "vantage/vision/marker_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;

// Discs seen more obliquely than this are not looked for anywhere.
constexpr double kLeastCosIncidence = 0.12;

int Round(double value) noexcept {
  return static_cast<int>(std::lround(std::clamp(value, -1e8, 1e8)));
}

double SearchMargin(const MarkerPrediction& prediction, const DetectorOptions& options) noexcept {
  return std::min(options.search_margin, prediction.uncertainty);
}

bool AreaFits(const DiscBlob& blob, const DiscImage& predicted, double tolerance,
              double slack) noexcept {
  return std::abs(blob.area / predicted.area - 1.0) <= tolerance + slack / predicted.area;
}

// Offsets of a square spiral, nearest first.
struct Spiral {
  int u{0}, v{0}, du{1}, dv{0}, run{1}, left{1}, turns{0};
  void Next() noexcept {
    u += du;
    v += dv;
    if (--left > 0) return;
    std::swap(du, dv);
    du = -du;
    if (++turns % 2 == 0) ++run;
    left = run;
  }
};

MarkerDetection DetectOne(const GreyView& image, const CameraModel& camera,
                          const MarkerPrediction& prediction,
                          const DetectorOptions& options) noexcept {
  MarkerDetection detection;
  detection.id = prediction.id;
  if (!prediction.expected) {
    detection.fault = MarkerFault::kNotExpected;
    return detection;
  }
  const PixelWindow window = Clip(SearchWindow(prediction, options), image.width, image.height);
  const int u0 = Round(prediction.image.centroid.x());
  const int v0 = Round(prediction.image.centroid.y());
  // Look from the predicted centre first, then from a grid about it that no disc slips through.
  const int step = std::max(2, static_cast<int>(1.2 * SemiAxes(prediction.image.shape).x()));
  const int reach = static_cast<int>(std::ceil(SearchMargin(prediction, options) / step));
  const int seeds = (2 * reach + 1) * (2 * reach + 1);
  Spiral at;
  for (int i = 0; i < seeds; ++i, at.Next()) {
    const int u = u0 + at.u * step;
    const int v = v0 + at.v * step;
    if (!window.contains(u, v)) continue;
    DiscBlob blob = MeasureDisc(image, window, u, v, prediction.dark, options.disc);
    if (blob.fault == MarkerFault::kNone &&
        !AreaFits(blob, prediction.image, options.area_tolerance, options.area_slack)) {
      blob.fault = MarkerFault::kWrongArea;
    }
    // The reason given is that of the look from the predicted centre, where the marker should be.
    if (i == 0 || blob.fault == MarkerFault::kNone) detection.fault = blob.fault;
    if (blob.fault != MarkerFault::kNone) continue;
    detection.centroid = blob.centroid;
    detection.area = blob.area;
    detection.pixel = PublishedPixel(camera, prediction.image, blob.centroid);
    break;
  }
  return detection;
}

// One dot never answers to two names.
void RefuseDoubles(double min_spacing, MarkerDetections* detections) noexcept {
  for (std::size_t i = 0; i < detections->size(); ++i) {
    for (std::size_t j = i + 1; j < detections->size(); ++j) {
      MarkerDetection& a = (*detections)[i];
      MarkerDetection& b = (*detections)[j];
      const auto found = [](const MarkerDetection& d) {
        return d.valid() || d.fault == MarkerFault::kAmbiguous;
      };
      if (!found(a) || !found(b) || (a.centroid - b.centroid).norm() >= min_spacing) continue;
      a.fault = MarkerFault::kAmbiguous;
      b.fault = MarkerFault::kAmbiguous;
    }
  }
}

// Similarity transform p -> scale R p + shift as (a, b, tx, ty): (a x - b y + tx, b x + a y + ty).
struct Similarity {
  double a{1.0}, b{0.0}, tx{0.0}, ty{0.0};
  [[nodiscard]] Vector2d operator*(const Vector2d& p) const noexcept {
    return {a * p.x() - b * p.y() + tx, b * p.x() + a * p.y() + ty};
  }
};

// The transform that takes p0 to q0 and p1 to q1.
Similarity FromPairs(const Vector2d& p0, const Vector2d& p1, const Vector2d& q0,
                     const Vector2d& q1) noexcept {
  const Vector2d p = p1 - p0;
  const Vector2d q = q1 - q0;
  Similarity t;
  t.a = (p.x() * q.x() + p.y() * q.y()) / p.squaredNorm();
  t.b = (p.x() * q.y() - p.y() * q.x()) / p.squaredNorm();
  t.tx = q0.x() - t.a * p0.x() + t.b * p0.y();
  t.ty = q0.y() - t.b * p0.x() - t.a * p0.y();
  return t;
}

struct Naming {
  std::vector<int> blob;  // Of each prediction of the group; -1: none.
  int found{0};
  double error{std::numeric_limits<double>::infinity()};  // Sum of squared distances [px²].
  double change{0.0};                                     // Of the transform from identity [px].

  // More names first, then the smaller residual and change together.
  [[nodiscard]] double cost() const noexcept { return error + 0.05 * change * change; }
  [[nodiscard]] bool BetterThan(const Naming& other) const noexcept {
    return found != other.found ? found > other.found : cost() < other.cost();
  }
};

class GroupNamer {
 public:
  GroupNamer(const std::vector<MarkerPrediction>& predictions, std::vector<int> members,
             const std::vector<DiscBlob>& blobs, const std::vector<bool>& blob_dark,
             const std::vector<bool>& taken, const AcquisitionOptions& options)
      : predictions_(predictions), members_(std::move(members)), blobs_(blobs), options_(options) {
    for (const int member : members_) {
      std::vector<int> fits;
      const MarkerPrediction& prediction = predictions_[member];
      for (std::size_t j = 0; j < blobs_.size(); ++j) {
        const double ratio = blobs_[j].area / prediction.image.area;
        if (taken[j] || blob_dark[j] != prediction.dark) continue;
        if (std::max(ratio, 1.0 / ratio) > 1.0 + options_.area_tolerance) continue;
        fits.push_back(static_cast<int>(j));
      }
      candidates_.push_back(std::move(fits));
      centre_ += prediction.image.centroid / static_cast<double>(members_.size());
    }
  }

  // Tries every transform that one or two pairs of a prediction and a dot suggest.
  void Solve() {
    for (std::size_t i = 0; i < members_.size(); ++i) {
      for (const int j : candidates_[i]) {
        const Vector2d shift = blobs_[j].centroid - At(i);
        Similarity t;
        t.tx = shift.x();
        t.ty = shift.y();
        Try(t);
      }
    }
    for (std::size_t i = 0; i < members_.size(); ++i) {
      for (std::size_t k = 0; k < members_.size(); ++k) {
        if (i == k || (At(i) - At(k)).norm() < 5.0) continue;
        for (const int j : candidates_[i]) {
          for (const int l : candidates_[k]) {
            if (j != l) Try(FromPairs(At(i), At(k), blobs_[j].centroid, blobs_[l].centroid));
          }
        }
      }
    }
  }

  [[nodiscard]] const std::vector<int>& members() const noexcept { return members_; }

  // Blob of each member, in their order; -1: none, -2: ambiguous.
  [[nodiscard]] std::vector<int> Result() const {
    std::vector<int> result(members_.size(), -1);
    if (best_.found == 0) return result;
    result = best_.blob;
    // A rival that names as many, but otherwise, and not clearly worse.
    if (rival_.found == best_.found && rival_.cost() < 4.0 * best_.cost() + 9.0 * best_.found) {
      for (std::size_t i = 0; i < result.size(); ++i) {
        if (rival_.blob[i] != result[i]) result[i] = -2;
      }
    }
    return result;
  }

  // Fits better than another group: larger share found, then the lower cost each.
  [[nodiscard]] bool BetterThan(const GroupNamer& other) const {
    const double share = static_cast<double>(best_.found) / static_cast<double>(members_.size());
    const double rival =
        static_cast<double>(other.best_.found) / static_cast<double>(other.members_.size());
    if (share != rival) return share > rival;
    return best_.cost() * other.best_.found < other.best_.cost() * best_.found;
  }

 private:
  [[nodiscard]] const Vector2d& At(std::size_t i) const {
    return predictions_[members_[i]].image.centroid;
  }

  [[nodiscard]] bool Allowed(const Similarity& t) const {
    const double scale = std::hypot(t.a, t.b);
    return scale <= options_.max_scale && scale >= 1.0 / options_.max_scale &&
           std::abs(std::atan2(t.b, t.a)) <= options_.max_turn &&
           (t * centre_ - centre_).norm() <= options_.max_shift;
  }

  void Try(const Similarity& t) {
    if (!Allowed(t)) return;
    Naming naming = Assign(t);
    if (naming.found == 0) return;
    if (naming.blob == best_.blob) {
      if (naming.BetterThan(best_)) best_ = naming;
      return;
    }
    if (naming.BetterThan(best_)) {
      rival_ = std::move(best_);
      best_ = std::move(naming);
    } else if (naming.BetterThan(rival_)) {
      rival_ = std::move(naming);
    }
  }

  // One to one, nearest pairs first.
  [[nodiscard]] Naming Assign(const Similarity& t) const {
    struct Pair {
      double distance2;
      int member, blob;
    };
    std::vector<Pair> pairs;
    Naming naming;
    naming.blob.assign(members_.size(), -1);
    naming.error = 0.0;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      const Vector2d p = t * At(i);
      naming.change += (p - At(i)).norm() / static_cast<double>(members_.size());
      for (const int j : candidates_[i]) {
        const double distance2 = (blobs_[j].centroid - p).squaredNorm();
        if (distance2 <= options_.gate * options_.gate) {
          pairs.push_back({distance2, static_cast<int>(i), j});
        }
      }
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
      return std::tie(a.distance2, a.member, a.blob) < std::tie(b.distance2, b.member, b.blob);
    });
    for (const Pair& pair : pairs) {
      const bool taken = naming.blob[pair.member] >= 0 ||
                         std::count(naming.blob.begin(), naming.blob.end(), pair.blob) > 0;
      if (taken) continue;
      naming.blob[pair.member] = pair.blob;
      naming.error += pair.distance2;
      ++naming.found;
    }
    return naming;
  }

  const std::vector<MarkerPrediction>& predictions_;
  std::vector<int> members_;
  const std::vector<DiscBlob>& blobs_;
  AcquisitionOptions options_;
  std::vector<std::vector<int>> candidates_;
  Vector2d centre_{Vector2d::Zero()};
  Naming best_, rival_;
};

}  // namespace

MarkerPrediction PredictMarker(const CameraModel& camera, const Isometry3d& X_CF,
                               const Marker& marker, int group, double max_incidence) noexcept {
  MarkerPrediction prediction;
  prediction.id = marker.id;
  prediction.group = group;
  prediction.dark = marker.dark;
  const std::optional<DiscImage> image = ProjectDisc(camera, X_CF, marker);
  if (!image) return prediction;
  prediction.image = *image;
  prediction.expected = image->cos_incidence >= std::cos(max_incidence) &&
                        InImage(camera, image->centroid) && image->area > 0.0;
  return prediction;
}

void PredictMarkers(const CameraModel& camera, const Isometry3d& X_CW, const Isometry3d& X_CE,
                    const std::vector<Marker>& tool_markers,
                    const std::vector<Marker>& goal_markers,
                    std::vector<MarkerPrediction>* predictions) {
  predictions->clear();
  for (const Marker& marker : tool_markers) {
    predictions->push_back(PredictMarker(camera, X_CE, marker, kToolGroup));
  }
  for (const Marker& marker : goal_markers) {
    predictions->push_back(PredictMarker(camera, X_CW, marker, kGoalGroup));
  }
}

Vector2d PublishedPixel(const CameraModel& camera, const DiscImage& predicted,
                        const Vector2d& centroid) noexcept {
  return UndistortPixel(camera, centroid) + predicted.centre -
         UndistortPixel(camera, predicted.centroid);
}

PixelWindow SearchWindow(const MarkerPrediction& prediction,
                         const DetectorOptions& options) noexcept {
  const Vector2d half = 2.0 * prediction.image.shape.diagonal().cwiseSqrt() +
                        Vector2d::Constant(SearchMargin(prediction, options) + 2.0);
  const int u = Round(std::floor(prediction.image.centroid.x() - half.x()));
  const int v = Round(std::floor(prediction.image.centroid.y() - half.y()));
  return {u, v, Round(std::ceil(2.0 * half.x())) + 1, Round(std::ceil(2.0 * half.y())) + 1};
}

void DetectMarkers(const GreyView& image, const CameraModel& camera,
                   const std::vector<MarkerPrediction>& predictions, const DetectorOptions& options,
                   MarkerDetections* detections) {
  detections->clear();
  for (const MarkerPrediction& prediction : predictions) {
    detections->push_back(DetectOne(image, camera, prediction, options));
  }
  RefuseDoubles(options.min_spacing, detections);
}

std::vector<DiscBlob> FindDiscs(const GreyView& image, bool dark, double least_semi_axis,
                                const DiscOptions& options) {
  std::vector<DiscBlob> found;
  // A square lattice of this step has a point within 0.78 of the least semi-axis of any disc's centre.
  const int step = std::clamp(static_cast<int>(1.1 * least_semi_axis), 2, 16);
  const PixelWindow all{0, 0, image.width, image.height};
  for (int v = step / 2; v < image.height; v += step) {
    for (int u = step / 2; u < image.width; u += step) {
      const auto known = std::find_if(found.begin(), found.end(), [&](const DiscBlob& blob) {
        return blob.bounds.contains(u, v);
      });
      if (known != found.end()) {
        u = std::max(u, known->bounds.u + known->bounds.width - 1);
        continue;
      }
      const DiscBlob blob = MeasureDisc(image, all, u, v, dark, options);
      if (blob.fault != MarkerFault::kNone) continue;
      // The box of an inclined ellipse has corners that a neighbour's seed may lie in: no dot twice.
      const bool twice = std::any_of(found.begin(), found.end(), [&](const DiscBlob& other) {
        return (other.centroid - blob.centroid).norm() < 1.0;
      });
      if (!twice) found.push_back(blob);
    }
  }
  return found;
}

std::vector<int> NameDiscs(const std::vector<MarkerPrediction>& predictions,
                           const std::vector<DiscBlob>& blobs, const std::vector<bool>& blob_dark,
                           const AcquisitionOptions& acquisition) {
  std::vector<int> names(predictions.size(), -1);
  std::vector<bool> taken(blobs.size(), false);
  std::vector<int> groups;
  for (const MarkerPrediction& prediction : predictions) {
    if (prediction.image.area > 0.0) groups.push_back(prediction.group);
  }
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  // Groups know nothing of one another: the one that fits best takes its dots first.
  while (!groups.empty()) {
    std::optional<GroupNamer> best;
    for (const int group : groups) {
      std::vector<int> members;
      for (std::size_t i = 0; i < predictions.size(); ++i) {
        if (predictions[i].group == group && predictions[i].image.area > 0.0) {
          members.push_back(static_cast<int>(i));
        }
      }
      GroupNamer namer(predictions, std::move(members), blobs, blob_dark, taken, acquisition);
      namer.Solve();
      if (!best || namer.BetterThan(*best)) best.emplace(std::move(namer));
    }
    const std::vector<int> found = best->Result();
    for (std::size_t i = 0; i < found.size(); ++i) {
      names[best->members()[i]] = found[i];
      if (found[i] >= 0) taken[found[i]] = true;
    }
    const int done = predictions[best->members().front()].group;
    groups.erase(std::find(groups.begin(), groups.end(), done));
  }
  return names;
}

MarkerDetections AcquireMarkers(const GreyView& image, const CameraModel& camera,
                                const std::vector<MarkerPrediction>& predictions,
                                const DetectorOptions& options,
                                const AcquisitionOptions& acquisition) {
  std::vector<MarkerPrediction> sought = predictions;
  for (MarkerPrediction& prediction : sought) {
    const bool near = InImage(camera, prediction.image.centroid, -acquisition.max_shift);
    if (prediction.image.cos_incidence < kLeastCosIncidence || !near) prediction.image.area = 0.0;
  }
  std::vector<DiscBlob> blobs;
  std::vector<bool> blob_dark;
  for (const bool dark : {true, false}) {
    double least = std::numeric_limits<double>::infinity();
    double largest = 0.0;
    for (const MarkerPrediction& prediction : sought) {
      if (prediction.dark != dark || !(prediction.image.area > 0.0)) continue;
      const Vector2d axes = SemiAxes(prediction.image.shape);
      // The lattice has some room to spare: discs smaller than predicted by the full scale are still hit
      // in most places.
      least = std::min(least, axes.x() / 1.15);
      largest = std::max(largest, axes.y() * acquisition.max_scale);
    }
    if (largest == 0.0) continue;
    DiscOptions disc = options.disc;
    disc.max_semi_axis = std::min(disc.max_semi_axis, 1.3 * largest + 2.0);
    for (const DiscBlob& blob : FindDiscs(image, dark, std::max(least, disc.min_semi_axis), disc)) {
      blobs.push_back(blob);
      blob_dark.push_back(dark);
    }
  }
  const std::vector<int> names = NameDiscs(sought, blobs, blob_dark, acquisition);
  MarkerDetections detections;
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    MarkerDetection detection;
    detection.id = predictions[i].id;
    detection.fault = names[i] == -2 ? MarkerFault::kAmbiguous : MarkerFault::kNotFound;
    if (names[i] >= 0) {
      const DiscBlob& blob = blobs[names[i]];
      detection.fault = MarkerFault::kNone;
      detection.centroid = blob.centroid;
      detection.area = blob.area;
      detection.pixel = PublishedPixel(camera, predictions[i].image, blob.centroid);
    }
    detections.push_back(detection);
  }
  return detections;
}

}  // namespace vantage
