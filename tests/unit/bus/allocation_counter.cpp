// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/bus/allocation_counter.h"

#include <cstdlib>
#include <new>

namespace plslam::bus::test {

std::atomic<size_t> allocated = 0;

}  // namespace plslam::bus::test

void* operator new(size_t n) {
  plslam::bus::test::allocated += n;
  void* p = std::malloc(n);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
void* operator new(size_t n, const std::nothrow_t&) noexcept {
  plslam::bus::test::allocated += n;
  return std::malloc(n);
}
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }
