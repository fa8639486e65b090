// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/machine.h"

#include <fstream>
#include <thread>

#include <fmt/format.h>

namespace plslam {

std::string MachineText() {
  const unsigned n = std::thread::hardware_concurrency();
  std::string text = fmt::format("{} core{}", n, n == 1 ? "" : "s");
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return text + " of " + line.substr(colon + 2);
  }
  return text;
}

}  // namespace plslam
