// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/ros_topics.h"

#include <array>

namespace plslam {

std::span<const RosTopic> RosTopics() {
  namespace t = ros_topic;
  static constexpr std::array kTopics = {t::kTf,        t::kTfStatic,  t::kOdom,      t::kPose,
                                         t::kPath,      t::kPathLive,  t::kPathTruth, t::kLeftImage,
                                         t::kLeftInfo,  t::kMapPoints, t::kMapLines,  t::kLoops,
                                         t::kKeyframes, t::kSurfaces,  t::kGrid,      t::kDiagnostics};
  return kTopics;
}

}  // namespace plslam
