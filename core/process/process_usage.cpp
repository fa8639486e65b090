// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process_usage.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace plslam::bus {
namespace {

double Seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

}  // namespace

Usage CurrentUsage() {
  Usage usage;
  rusage r{};
  if (getrusage(RUSAGE_SELF, &r) == 0) usage.cpu_s = Seconds(r.ru_utime) + Seconds(r.ru_stime);
  std::ifstream statm("/proc/self/statm");
  double total_pages = 0, resident_pages = 0;
  if (statm >> total_pages >> resident_pages) {
    usage.memory_mb = resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
  }
  return usage;
}

std::string HostName() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "unknown";
}

}  // namespace plslam::bus
