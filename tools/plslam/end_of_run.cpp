// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/end_of_run.h"

namespace plslam::launcher {

EndOfRun::Wait EndOfRun::Look(const EndSigns& signs, TimePoint now) {
  const bool plays = !signs.stream_ended || signs.source_sends;
  const bool news = signs.poses != last_.poses || signs.map_version != last_.map_version;
  if (plays || news || signs.maps) news_at_ = now;
  last_ = signs;
  if (wait_ != Wait::kNothing) wait_ = Next(signs, now);
  return wait_;
}

EndOfRun::Wait EndOfRun::Next(const EndSigns& signs, TimePoint now) const {
  if (!signs.stream_ended || signs.source_sends) return Wait::kStream;
  const bool tracked = signs.has_all_poses && signs.tracker_finished;
  if (!tracked && now - news_at_ <= kPoseLimit) return Wait::kPoses;
  if (!signs.has_map && now - news_at_ <= kMapLimit) return Wait::kMap;
  return Wait::kNothing;
}

}  // namespace plslam::launcher
