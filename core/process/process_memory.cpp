// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process_memory.h"

#include <malloc.h>

#include <cstddef>
#include <cstdlib>

namespace plslam::bus {
namespace {

constexpr int kLargestBlock = 32 << 20;  // the most that glibc takes from its heap
constexpr int kKept = 4 * kLargestBlock;
/// Freeing a block of at least 64 kB makes glibc look at what it can give back.
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

}  // namespace plslam::bus
