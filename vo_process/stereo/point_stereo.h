// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "core/features/features.h"
#include "core/features/options.h"
#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// `points` as stereo points without depth, with `sigma_px` set from their scales.
std::vector<StereoPoint> WithoutDepth(std::vector<PointFeature> points, const StereoOptions& options);

/// The right point that a left one looks most like; `index` is negative for none.
struct PointCandidate {
  int index = -1;
  int distance = 0;
  int second_distance = 0;
};

/// For each left point its candidate (PL-SLAM §IV.A), the right ones having been brought to left rows: on the same
/// row (with a `skew`, on the row that it leads to) within `point_row_tolerance_px` times the scale of the octave, at
/// most one octave apart, with a disparity in range; its descriptor must be near enough, clearly nearer than the
/// second, and mutually best.
std::vector<PointCandidate> FindPointCandidates(const std::vector<StereoPoint>& left,
                                                const std::vector<PointFeature>& right, const PairSkew& skew,
                                                const StereoOptions& options);

/// Sets the disparities of left points and their standard deviations by aligning patches of the two images
/// (`PatchAligner`) at the candidates, or where a search along the row finds the patch. Points whose patches do not
/// correlate keep a negative disparity. `rows` tells where in the right image their rows are.
///
/// Points are matched independently of each other, a few at a time from `begun` on, which counts those that somebody
/// has begun: threads that call this with one `begun`, at 0 before the first of them, share the points, and each
/// returns when none is left to begin.
void MatchPointsStereo(std::vector<StereoPoint>& left, const std::vector<PointFeature>& right,
                       const std::vector<PointCandidate>& candidates, const HalvedPair& pair, const RowField& rows,
                       const StereoOptions& options, std::atomic<size_t>& begun);

}  // namespace plslam::vo
