// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <set>
#include <string>

#include "core/errors/log.h"

namespace plslam::robot {

/// Warnings about foreign messages: each sentence is logged once, and only a few in total.
class SkippedMessages {
 public:
  void WarnOnce(const std::string& sentence) {
    if (warned_.size() < kMost && warned_.insert(sentence).second) LogWarning("skipped: {}", sentence);
  }

 private:
  static constexpr size_t kMost = 20;
  std::set<std::string> warned_;
};

}  // namespace plslam::robot
