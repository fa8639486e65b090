// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "ros2/diagnosis.h"

namespace plslam::ros2 {

/// Images received on a topic within the time of listening.
struct HeardImages {
  int64_t n = 0;
  int64_t bytes = 0;
  std::string encoding;  ///< of the last one; empty: JPEG or PNG
  int64_t width_px = 0, height_px = 0;
};

/// Returns a table of the topics, with rates of images, and the commands that use the pairs that look like stereo
/// cameras, with the inertial sensor beside them.
std::string TopicTable(const std::vector<Publisher>& publishers, const std::map<std::string, HeardImages>& heard,
                       double listened_s, int domain);

}  // namespace plslam::ros2
