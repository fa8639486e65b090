// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/run/run_warnings.h"

namespace plslam {

/// The warnings that the processes of a run have published, in the order of arrival; a process that was started again
/// repeats its own, which are listed once.
class PublishedWarnings {
 public:
  void Add(const std::string& code, const std::string& sentence) {
    const auto is_same = [&](const RunWarning& w) { return w.code == code && w.sentence == sentence; };
    if (warnings_.size() < kMost && std::ranges::none_of(warnings_, is_same))
      warnings_.push_back({code, sentence, {}});
  }
  const std::vector<RunWarning>& all() const { return warnings_; }

 private:
  /// Of all processes: more are invented.
  static constexpr size_t kMost = 500;

  std::vector<RunWarning> warnings_;
};

}  // namespace plslam
