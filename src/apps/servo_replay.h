#pragma once

#include <string>

#include "vantage/replay/replay.h"

namespace vantage {

/// Replays a log and prints how the outputs compare. An exit code: kExitOk only when all are reproduced.
int PrintReplay(const std::string& log_path, const ReplayOptions& options);

}  // namespace vantage
