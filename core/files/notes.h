// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace plslam {

/// Sentences for the user about data that were read.
struct Notes {
  /// Faults that can make results wrong or incomplete: data that were skipped, contradict each other, or have been
  /// interpreted although they can hardly be meant so.
  std::vector<std::string> warnings{};
  /// Properties that correct data can have: a choice that was made, a format that was assumed.
  std::vector<std::string> remarks{};

  void Warn(std::string sentence) { warnings.push_back(std::move(sentence)); }
  void Remark(std::string sentence) { remarks.push_back(std::move(sentence)); }
  /// A warning if `is_fault`, else a remark.
  void Add(bool is_fault, std::string sentence) { (is_fault ? warnings : remarks).push_back(std::move(sentence)); }
  void Add(const Notes& others) {
    warnings.insert(warnings.end(), others.warnings.begin(), others.warnings.end());
    remarks.insert(remarks.end(), others.remarks.begin(), others.remarks.end());
  }
  bool empty() const { return warnings.empty() && remarks.empty(); }
};

}  // namespace plslam
