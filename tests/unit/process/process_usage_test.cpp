// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/process/process_usage.h"

namespace plslam::bus {
namespace {

TEST(ProcessMemory, MemoryFreedByAThreadIsReturned) {
#ifdef PLSLAM_SANITIZED
  GTEST_SKIP() << "a sanitizer keeps what is freed";
#endif
  KeepFreedMemory();
  double used_mb = 0.0, kept_mb = 0.0, given_back_mb = 0.0;
  std::thread([&] {
    const double before_mb = CurrentUsage().memory_mb;
    {
      std::vector<std::unique_ptr<std::array<char, 500>>> blocks(40'000);
      for (auto& block : blocks) block = std::make_unique<std::array<char, 500>>();
      used_mb = CurrentUsage().memory_mb - before_mb;
    }
    kept_mb = CurrentUsage().memory_mb - before_mb;
    GiveBackFreedMemory();
    given_back_mb = CurrentUsage().memory_mb - before_mb;
  }).join();
  EXPECT_GT(used_mb, 20.0);
  EXPECT_GT(kept_mb, 15.0) << "while frames come, their memory stays";
  EXPECT_LT(given_back_mb, 2.0);
}

}  // namespace
}  // namespace plslam::bus
