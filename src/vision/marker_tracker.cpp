#include "vantage/vision/marker_tracker.h"

#include <algorithm>
#include <cmath>

#include "vantage/vision/visp_dot.h"

namespace vantage {
namespace {

using Eigen::Vector2d;

// Rates from images farther apart than this say nothing about the next one [s].
constexpr double kMaxGapOfRates = 0.2;

}  // namespace

MarkerTracker::MarkerTracker(const CameraModel& camera, const TrackerOptions& options)
    : camera_(camera), options_(options) {
  tracks_.reserve(kMaxMarkers);
  corrected_.reserve(kMaxMarkers);
  detections_.reserve(kMaxMarkers);
  plan_.windows.reserve(kMaxMarkers);
  if (options_.kind == DetectorKind::kAprilTag) tags_.emplace();
}

void MarkerTracker::Reset() {
  tracks_.clear();
  last_exposure_ = Time::min();
  last_acquisition_ = Time::min();
}

MarkerTracker::Track_* MarkerTracker::Find(int id) {
  for (Track_& track : tracks_) {
    if (track.id == id) return &track;
  }
  return nullptr;
}

// Predictions moved by what is known of the model's error: the marker's own, else its group's.
void MarkerTracker::Correct(const std::vector<MarkerPrediction>& predictions, Time exposure) {
  corrected_ = predictions;
  for (MarkerPrediction& prediction : corrected_) {
    Track_* track = Find(prediction.id);
    if (track == nullptr) {
      tracks_.emplace_back();
      track = &tracks_.back();
      track->id = prediction.id;
    }
    track->group = prediction.group;
    if (track->known && ToSeconds(exposure - track->last_seen) > options_.memory)
      track->known = false;
  }
  for (MarkerPrediction& prediction : corrected_) {
    const Track_& own = *Find(prediction.id);
    Vector2d offset = Vector2d::Zero();
    double area_ratio = 1.0;
    if (own.known) {
      const double age = ToSeconds(exposure - own.last_seen);
      offset = own.offset + own.rate * std::min(age, kMaxGapOfRates);
      area_ratio = own.area_ratio;
      if (own.followed && age < kMaxGapOfRates) prediction.uncertainty = options_.followed_margin;
    } else {
      int known = 0;
      double ratios = 0.0;
      for (const Track_& track : tracks_) {
        if (!track.known || track.group != own.group) continue;
        offset += track.offset;
        ratios += track.area_ratio;
        ++known;
      }
      if (known > 0) {
        offset /= known;
        area_ratio = ratios / known;
      }
    }
    prediction.image.centroid += offset;
    prediction.image.centre += offset;
    prediction.image.area *= area_ratio;
    prediction.image.shape *= area_ratio;
    if (prediction.expected) {
      prediction.expected = InImage(camera_, prediction.image.centroid);
    } else if (prediction.image.area > 0.0 && prediction.image.cos_incidence > 0.2 && own.seen) {
      // Outside the image by the model, inside by experience.
      prediction.expected = InImage(camera_, prediction.image.centroid);
    }
  }
}

// A marker that should be seen and was not last time cannot be followed: look everywhere, but not all the
// time.
bool MarkerTracker::WantsWholeImage(Time exposure) const {
  if (tags_) return true;
  if (last_acquisition_ != Time::min() &&
      ToSeconds(exposure - last_acquisition_) < options_.retry_interval) {
    return false;
  }
  return std::any_of(corrected_.begin(), corrected_.end(), [&](const MarkerPrediction& prediction) {
    return prediction.expected &&
           std::none_of(tracks_.begin(), tracks_.end(), [&](const Track_& track) {
             return track.id == prediction.id && track.seen;
           });
  });
}

const MarkerTracker::SearchPlan& MarkerTracker::Plan(
    const std::vector<MarkerPrediction>& predictions, Time exposure) {
  Correct(predictions, exposure);
  plan_.windows.clear();
  plan_.whole_image = WantsWholeImage(exposure);
  if (plan_.whole_image) return plan_;
  for (const MarkerPrediction& prediction : corrected_) {
    if (!prediction.expected) continue;
    const PixelWindow window =
        Clip(SearchWindow(prediction, options_.detector), camera_.width, camera_.height);
    if (!window.empty()) plan_.windows.push_back(window);
  }
  return plan_;
}

void MarkerTracker::Detect(const GreyView& image, bool whole_image, Time exposure) {
  if (tags_) {
    tags_->Detect(image, camera_, corrected_, options_.detector, options_.acquisition.max_shift,
                  &detections_);
    return;
  }
  const auto measure = options_.kind == DetectorKind::kVispDot ? DetectWithVispDot : DetectMarkers;
  measure(image, camera_, corrected_, options_.detector, &detections_);
  if (!whole_image) return;
  const bool complete =
      std::all_of(detections_.begin(), detections_.end(), [](const MarkerDetection& detection) {
        return detection.valid() || detection.fault == MarkerFault::kNotExpected;
      });
  if (complete) return;
  ++acquisitions_;
  last_acquisition_ = exposure;
  const MarkerDetections found =
      AcquireMarkers(image, camera_, corrected_, options_.detector, options_.acquisition);
  for (std::size_t i = 0; i < found.size(); ++i) {
    // What the search of the whole image names rests on the whole group: it overrules.
    if (found[i].valid()) detections_[i] = found[i];
  }
}

const MarkerDetections& MarkerTracker::Track(const GreyView& image,
                                             const std::vector<MarkerPrediction>& predictions,
                                             Time exposure) {
  if (exposure < last_exposure_) Reset();
  Correct(predictions, exposure);
  const bool whole_image = WantsWholeImage(exposure);
  Detect(image, whole_image, exposure);
  Learn(predictions, exposure);
  last_exposure_ = exposure;
  return detections_;
}

void MarkerTracker::Learn(const std::vector<MarkerPrediction>& predictions, Time exposure) {
  for (std::size_t i = 0; i < detections_.size(); ++i) {
    Track_& track = *Find(detections_[i].id);
    const bool was_seen = track.seen;
    track.seen = detections_[i].valid();
    track.followed = false;
    if (!track.seen) continue;
    const Vector2d offset = detections_[i].centroid - predictions[i].image.centroid;
    const double gap = ToSeconds(exposure - track.last_seen);
    if (was_seen && gap > 0.0 && gap < kMaxGapOfRates) {
      track.followed = true;
      track.rate = (offset - track.offset) / gap;
    } else {
      track.rate.setZero();
    }
    track.offset = offset;
    track.area_ratio = std::clamp(detections_[i].area / predictions[i].image.area, 0.5, 2.0);
    track.last_seen = exposure;
    track.known = true;
  }
}

void MarkerTracker::Publish(ImageFeatures* features) const noexcept {
  features->count = static_cast<int>(std::min<std::size_t>(detections_.size(), kMaxMarkers));
  for (int i = 0; i < features->count; ++i) {
    features->markers[i] = {detections_[i].id, detections_[i].pixel, detections_[i].valid()};
  }
}

}  // namespace vantage
