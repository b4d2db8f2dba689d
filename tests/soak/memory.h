#pragma once

#include <fstream>
#include <string>

#include <unistd.h>

namespace vantage::soak {

/// Resident memory of a process [MiB]; 0: there is none.
inline double ResidentMebibytes(const std::string& pid = "self") {
  std::ifstream file("/proc/" + pid + "/statm");
  double total = 0.0, resident = 0.0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

}  // namespace vantage::soak
