// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/odometry.h"

namespace plslam {

/// Stereo features of the next pair, for `odometry.Track`, with rows that differ as they are known to; what the pair
/// tells of them is learned. The first pair is looked at twice, since landmarks are created on it: before all for
/// rows that may differ by much. So are further ones until there was enough to see, and one that changes whether rows
/// differ. Throws as `StereoFrontEnd::Process`.
inline StereoFeatures SeePair(StereoFrontEnd& front_end, Odometry& odometry, const StereoImages& images,
                              StageTimer& timer) {
  odometry.Expect(images.t_ns);
  const bool looks = odometry.needs_rows();
  if (looks) timer.Time("rows", [&] { odometry.LearnRows(front_end.LookForRows(images, odometry.rows().skew())); });
  StereoFeatures features = front_end.Process(images, timer, odometry.rows(), odometry.max_points());
  if (!looks && odometry.LearnRows(features))
    features = front_end.Process(images, timer, odometry.rows(), odometry.max_points());
  return features;
}

}  // namespace plslam
