// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spdlog/spdlog.h>

#include <cstddef>
#include <set>
#include <string>

namespace plslam::adapter {

/// What is wrong with foreign messages: each sentence is told once, and not more than a few of them.
class Complaints {
 public:
  void Tell(const std::string& sentence) {
    if (told_.size() < kMost && told_.insert(sentence).second) spdlog::warn("passed over: {}", sentence);
  }

 private:
  static constexpr size_t kMost = 20;
  std::set<std::string> told_;
};

}  // namespace plslam::adapter
