#pragma once

#include <vector>

#include "sim/render/scene.h"
#include "vantage/vision/april_tag.h"

namespace vantage::sim {

/// Adds AprilTags on the end effector: a white plate of a quiet border round the tag, a strut to it from
/// the end effector, and the black squares of the family 36h11. Throws ConfigError when a tag's id is none of the family's.
void AddTags(const std::vector<Tag>& tags, Scene* scene);

}  // namespace vantage::sim
