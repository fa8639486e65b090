// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "core/features/features.h"
#include "core/features/options.h"
#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/patch_aligner.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// Returns `points` as stereo points without depth, with `sigma_px` from their scales.
std::vector<StereoPoint> WithoutDepth(std::vector<PointFeature> points, const StereoOptions& options);

/// Removes the partner of a point, and so its depth.
inline void ForgetPartner(StereoPoint& point) {
  point.disparity_px = -1.0;
  point.row_offset_px = 0.0;
  point.sigma_row_px = -1.0;
}

/// The right point most similar to a left one; `index` is negative if there is none.
struct PointCandidate {
  int index = -1;
  int distance = 0;
  int second_distance = 0;
};

/// Returns the candidate of each left point (PL-SLAM §IV.A), for right points corrected to left rows: in the same row
/// (with a `skew`, in the row that it predicts) within `point_row_tolerance_px` times the scale of the octave, at most
/// one octave apart, with a disparity in range; its descriptor must be near enough, clearly nearer than the second, and
/// mutually best.
std::vector<PointCandidate> FindPointCandidates(const std::vector<StereoPoint>& left,
                                                const std::vector<PointFeature>& right, const PairSkew& skew,
                                                const StereoOptions& options);

/// Sets the disparities of left points and their standard deviations by aligning patches of the two images
/// (`PatchAligner`) at the candidates, or at the result of a search along the row. Points whose patches do not
/// correlate keep a negative disparity. `rows` maps their rows to the right image.
///
/// Points are matched independently, a few at a time; `begun` counts those taken by any thread. Threads that call this
/// with the same `begun`, initially 0, share the points, and each returns when none is left.
void MatchPointsStereo(std::vector<StereoPoint>& left, const std::vector<PointFeature>& right,
                       const std::vector<PointCandidate>& candidates, const HalvedPair& pair, const RowField& rows,
                       const StereoOptions& options, std::atomic<size_t>& begun);

/// Sets the disparity of a point whose disparity is expected at `expected_px`, as measured in the images; none if the
/// patches do not correlate there.
void AlignWithRight(const PatchAligner& aligner, double expected_px, const StereoOptions& options,
                    StereoPoint& point);

}  // namespace plslam::vo
