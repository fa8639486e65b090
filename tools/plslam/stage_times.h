// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "tools/plslam/quantile_sketch.h"

namespace plslam {

/// Times in ms by stage. Names come over the wire, where anybody may invent them: those beyond `kMaxStages` do not
/// count.
class StageTimes {
 public:
  static constexpr size_t kMaxStages = 64;

  void Add(const std::string& stage, double ms) {
    if (times_.size() < kMaxStages || times_.contains(stage)) times_[stage].Add(ms);
  }
  const std::map<std::string, QuantileSketch>& by_name() const { return times_; }

 private:
  std::map<std::string, QuantileSketch> times_;
};

}  // namespace plslam
