// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/static_frames.h"

namespace plslam {

void StaticFrames::Add(const std::string& parent, const std::string& child, const SE3& T_parent_child) {
  parents_[child] = {parent, T_parent_child};
}

std::optional<SE3> StaticFrames::Find(const std::string& base, const std::string& frame) const {
  SE3 T_ancestor_frame;
  std::string ancestor = frame;
  for (size_t n = 0; n <= parents_.size(); ++n) {
    if (ancestor == base) return T_ancestor_frame;
    const auto found = parents_.find(ancestor);
    if (found == parents_.end()) return std::nullopt;
    T_ancestor_frame = found->second.second * T_ancestor_frame;
    ancestor = found->second.first;
  }
  return std::nullopt;
}

std::optional<SE3> StaticFrames::Between(const std::string& a, const std::string& b) const {
  std::string ancestor = a;
  for (size_t n = 0; n <= parents_.size(); ++n) {
    if (const std::optional<SE3> T_ancestor_b = Find(ancestor, b)) {
      return Find(ancestor, a).value_or(SE3()).Inverse() * *T_ancestor_b;
    }
    const auto found = parents_.find(ancestor);
    if (found == parents_.end()) return std::nullopt;
    ancestor = found->second.first;
  }
  return std::nullopt;
}

}  // namespace plslam
