// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/stall_watch.h"

#include <fmt/format.h>

namespace plslam::launcher {

void StallWatch::Begin(TimePoint now) { news_at_ = viewer_at_ = now; }

std::string StallWatch::Look(const SignsOfLife& signs, TimePoint now) {
  const bool turned = signs.stream_ended != last_.stream_ended;
  // A new version of the map is no sign of a tracker.
  const bool new_map = signs.stream_ended && signs.map_version != last_.map_version;
  if (turned || new_map || signs.poses != last_.poses || signs.waits_for_time) news_at_ = now;
  if (turned || signs.viewer_heard_s != last_.viewer_heard_s) viewer_at_ = now;
  last_ = signs;
  if (!signs.stream_ended) {
    return now - news_at_ > kLimit ? fmt::format("no pose for {} s", kLimit.count()) : "";
  }
  if (now - viewer_at_ > kLimit) {
    return fmt::format("the stream has ended, and the viewer has sent nothing for {} s", kLimit.count());
  }
  if (now - news_at_ > kFinishLimit) {
    return fmt::format("the stream has ended, and the viewer has not finished {} s after the last pose and map",
                       kFinishLimit.count());
  }
  return "";
}

}  // namespace plslam::launcher
