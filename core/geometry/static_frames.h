// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/geometry/se3.h"

namespace plslam {

/// The tree of frames in /tf_static of ROS: where sensors are on the body.
class StaticFrames {
 public:
  /// p_parent = T_parent_child p_child. A later transform of a frame replaces the earlier one.
  void Add(const std::string& parent, const std::string& child, const SE3& T_parent_child);

  /// Returns T_base_frame; nullopt if `frame` is not below `base`, or the tree has a loop.
  std::optional<SE3> Find(const std::string& base, const std::string& frame) const;

  /// Returns T_a_b of two frames of one tree; nullopt if they have no common ancestor.
  std::optional<SE3> Between(const std::string& a, const std::string& b) const;

 private:
  std::map<std::string, std::pair<std::string, SE3>> parents_;  ///< by child
};

}  // namespace plslam
