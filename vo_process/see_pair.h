#pragma once

#include "vo_process/odometry.h"
#include "vo_process/stereo_front_end.h"

namespace plslam {

/// Stereo features of the next pair, for `odometry.Track`, with rows that differ as they are known to; what the pair tells of them
/// is learned. The first pair is looked at twice, since landmarks are founded on it: first for rows that may differ by much. So
/// is one that brings to light that they do. Throws as `StereoFrontEnd::Process`.
inline StereoFeatures SeePair(StereoFrontEnd& front_end, Odometry& odometry, const StereoImages& images,
                              StageTimer& timer) {
  if (!odometry.has_learned_rows()) odometry.LearnRows(front_end.LookForRows(images, timer));
  StereoFeatures features = front_end.Process(images, timer, odometry.rows());
  if (odometry.LearnRows(features)) features = front_end.Process(images, timer, odometry.rows());
  return features;
}

}  // namespace plslam
