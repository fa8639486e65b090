// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process_usage.h"

#include <unistd.h>

#include <sys/resource.h>
#include <cstddef>
#include <cstdlib>
#include <fstream>

#include <malloc.h>

namespace plslam::bus {
namespace {

constexpr int kLargestBlock = 32 << 20;  // the largest block that glibc takes from its heap
constexpr int kKept = 4 * kLargestBlock;
/// Freeing a block of at least 64 kB makes glibc check how much it can return.
constexpr size_t kNoticedBlock = 128 << 10;

}  // namespace

void KeepFreedMemory() {
  mallopt(M_MMAP_THRESHOLD, kLargestBlock);
  mallopt(M_TRIM_THRESHOLD, kKept);
}

void GiveBackFreedMemory() {
  malloc_trim(0);
  // It leaves the end of every heap but the main thread's (mtrim in glibc's malloc.c), where most of it lies.
  mallopt(M_TRIM_THRESHOLD, 0);
  void* volatile block = std::malloc(kNoticedBlock);
  std::free(block);
  mallopt(M_TRIM_THRESHOLD, kKept);
}

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

double PeakMemory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e-3 * static_cast<double>(usage.ru_maxrss);
}

std::string HostName() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "unknown";
}

}  // namespace plslam::bus
