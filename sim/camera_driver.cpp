#include "sim/camera_driver.h"

#include <algorithm>
#include <cmath>

namespace vantage::sim {
