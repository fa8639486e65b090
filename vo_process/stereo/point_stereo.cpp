// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/point_stereo.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/features/matching/buckets.h"
#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/patch_aligner.h"
#include "vo_process/stereo/row_search.h"

namespace plslam::vo {
namespace {

constexpr int kNone = 257;  // above any distance of 256 bits
constexpr int kMaxOctavesApart = 1;
/// Correlations that differ by less than this are equal: a repeated texture, up to rounding.
constexpr double kTieMargin = 0.005;
/// Correlation at pixel accuracy above which sub-pixel alignment may make a match equal to the best.
constexpr double kMaybeEqual = 0.5;
/// Disparities that differ by more than this, in pixels of the level, are different matches.
constexpr double kOther_px = 3.0;
constexpr double kMinGain = 0.25;
constexpr double kMaxGain = 4.0;
/// Points that a thread takes at once: some microseconds each.
constexpr size_t kPointsAtATime = 8;

/// Indices of the right points by integer row.
class RowIndex {
 public:
  explicit RowIndex(const std::vector<PointFeature>& points) {
    int rows = 0;
    for (const PointFeature& p : points) rows = std::max(rows, Row(p) + 1);
    rows_ = IndicesByBucket(points.size(), static_cast<size_t>(rows),
                            [&points](int i) { return Row(points[static_cast<size_t>(i)]); });
  }

  template <class Visit>
  void ForEachNear(double row_px, double tolerance_px, const Visit& visit) const {
    const int rows = static_cast<int>(rows_.size());
    const int first = std::clamp(static_cast<int>(std::floor(row_px - tolerance_px)), 0, rows);
    const int last = std::clamp(static_cast<int>(std::floor(row_px + tolerance_px)) + 1, first, rows);
    for (const int i : rows_.Range(static_cast<size_t>(first), static_cast<size_t>(last))) visit(i);
  }

 private:
  static int Row(const PointFeature& p) { return std::max(static_cast<int>(std::floor(p.px.y())), 0); }
  Buckets<int> rows_;
};

bool MayMatch(const PointFeature& left, const PointFeature& right, const PairSkew& skew,
              const StereoOptions& options) {
  if (std::abs(left.octave - right.octave) > kMaxOctavesApart) return false;
  const double scale = std::max(left.scale, right.scale);
  const double row_px = left.px.y() + skew.RowOffset_px(left.px, left.px.x() - right.px.x());
  if (std::abs(row_px - right.px.y()) > options.point_row_tolerance_px * scale) return false;
  // Corners are accurate to about a pixel of their octave; the gates on the disparity itself follow the alignment.
  const double disparity_px = left.px.x() - right.px.x();
  return disparity_px >= options.min_disparity_px - scale && disparity_px <= options.max_disparity_px + scale;
}

/// Lowest and highest row of a match under a skew, relative to that of the left point.
struct RowRange {
  double low_px = 0.0;
  double high_px = 0.0;
};

RowRange RowsOf(const PointFeature& left, const PairSkew& skew, const StereoOptions& options) {
  RowRange range;
  if (skew.is_zero()) return range;
  const double far_px = skew.RowOffset_px(left.px, options.min_disparity_px);
  const double near_px = skew.RowOffset_px(left.px, options.max_disparity_px);
  return {std::min(far_px, near_px), std::max(far_px, near_px)};
}

bool IsGood(const PatchAlignment& a, double scale, double min_correlation, const StereoOptions& options) {
  return a.correlation >= min_correlation && a.gain >= kMinGain && a.gain <= kMaxGain &&
         a.sigma_disparity_px <= options.point_max_sigma_disparity_px * scale;
}

/// Whether an alignment is good and gives a depth. Sets `is_far` of the point if it is good at about zero disparity.
bool Accept(const PatchAlignment& a, double min_correlation, const StereoOptions& options, StereoPoint& point) {
  const double scale = point.left.scale;
  if (!IsGood(a, scale, min_correlation, options)) return false;
  point.is_far = a.disparity_px < options.min_disparity_px && a.disparity_px > -scale;
  return a.disparity_px >= options.min_disparity_px && a.disparity_px <= options.max_disparity_px;
}

/// Whether a match with the first correlation is clearly better than one with the second.
bool IsUnique(double correlation, double second_correlation, const StereoOptions& options) {
  return 1.0 - correlation + kTieMargin <= options.point_direct_max_ratio * (1.0 - second_correlation);
}

/// Whether a position of a row search other than `found` matches as well at sub-pixel accuracy.
bool MatchesElsewhere(const PointFeature& feature, const PatchAlignment& found, const RowMatch& match,
                      const PatchAligner& aligner, const StereoOptions& options) {
  const auto matches_at = [&](double disparity_px, double correlation) {
    if (correlation < kMaybeEqual || std::abs(disparity_px - found.disparity_px) < kOther_px * feature.scale)
      return false;
    const auto other = aligner.Align(feature.px, feature.scale, disparity_px);
    if (!other) return false;
    // Interpolation blurs fine textures: alignment that gains much also loses much.
    const double loss = 2.0 * std::max(0.0, other->correlation - correlation);
    return !IsUnique(found.correlation, other->correlation + loss, options);
  };
  return matches_at(match.disparity_px, match.correlation) ||
         matches_at(match.second_disparity_px, match.second_correlation);
}

/// Searches the right row for the patch of the point. Sets `is_ambiguous` if two positions match equally well.
std::optional<PatchAlignment> FindInRow(StereoPoint& point, RowSearch& search, const PatchAligner& aligner,
                                        const StereoOptions& options) {
  const PointFeature& feature = point.left;
  const std::optional<RowMatch> match =
      search.Find(feature.px, feature.scale, options.min_disparity_px, options.max_disparity_px);
  if (!match) return std::nullopt;
  if (!IsUnique(match->correlation, match->second_correlation, options)) {
    point.is_ambiguous = match->second_correlation >= options.point_direct_min_correlation;
    return std::nullopt;
  }
  std::optional<PatchAlignment> found = aligner.Align(feature.px, feature.scale, match->disparity_px);
  if (!found || !Accept(*found, options.point_direct_min_correlation, options, point)) return std::nullopt;
  point.is_ambiguous = MatchesElsewhere(feature, *found, *match, aligner, options);
  if (point.is_ambiguous) return std::nullopt;
  return found;
}

/// Sets what an accepted alignment measured.
void SetDepth(const PatchAlignment& found, StereoPoint& point) {
  point.disparity_px = found.disparity_px;
  point.sigma_disparity_px = found.sigma_disparity_px;
  point.disparity_slope = found.disparity_slope;
  point.row_offset_px = found.row_offset_px;
  point.sigma_row_px = found.sigma_row_px;
}

void MatchPoint(StereoPoint& point, const PointFeature* candidate, RowSearch& search, const PatchAligner& aligner,
                const StereoOptions& options) {
  const PointFeature& feature = point.left;
  std::optional<PatchAlignment> found;
  if (candidate != nullptr) {
    found = aligner.Align(feature.px, feature.scale, feature.px.x() - candidate->px.x());
    if (found && !Accept(*found, options.point_min_correlation, options, point)) found.reset();
    const auto match = found && options.point_direct ? search.Find(feature.px, feature.scale,
                                                                   options.min_disparity_px, options.max_disparity_px)
                                                     : std::nullopt;
    point.is_ambiguous = match && MatchesElsewhere(feature, *found, *match, aligner, options);
    if (point.is_ambiguous) return;
  }
  if (!found && options.point_direct) found = FindInRow(point, search, aligner, options);
  if (found) SetDepth(*found, point);
}

}  // namespace

std::vector<StereoPoint> WithoutDepth(std::vector<PointFeature> points, const StereoOptions& options) {
  std::vector<StereoPoint> without(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    without[i].left = points[i];
    without[i].sigma_px = options.point_sigma_px * points[i].scale;
  }
  return without;
}

std::vector<PointCandidate> FindPointCandidates(const std::vector<StereoPoint>& left,
                                                const std::vector<PointFeature>& right, const PairSkew& skew,
                                                const StereoOptions& options) {
  if (left.empty()) return {};
  const RowIndex rows(right);
  const PointCandidate none{-1, kNone, kNone};
  std::vector<PointCandidate> candidates(left.size(), none);
  std::vector<PointCandidate> of_right(right.size(), none);
  for (size_t i = 0; i < left.size(); ++i) {
    const PointFeature& feature = left[i].left;
    PointCandidate& best = candidates[i];
    // The right point may be an octave coarser than the left.
    const double reach_px = options.point_row_tolerance_px * feature.scale * 2.0;
    const RowRange range = RowsOf(feature, skew, options);
    const double row_px = feature.px.y() + 0.5 * (range.low_px + range.high_px);
    rows.ForEachNear(row_px, reach_px + 0.5 * (range.high_px - range.low_px), [&](int j) {
      if (!MayMatch(feature, right[j], skew, options)) return;
      const int distance = HammingDistance(feature.descriptor, right[j].descriptor);
      if (distance < of_right[j].distance) of_right[j] = {static_cast<int>(i), distance, kNone};
      if (distance < best.distance) {
        best = {j, distance, best.distance};
      } else {
        best.second_distance = std::min(best.second_distance, distance);
      }
    });
  }
  for (size_t i = 0; i < left.size(); ++i) {
    PointCandidate& c = candidates[i];
    const bool accepted = c.index >= 0 && of_right[c.index].index == static_cast<int>(i) &&
                          c.distance <= options.point_max_descriptor_distance &&
                          (c.second_distance == kNone || c.distance < options.point_max_ratio * c.second_distance);
    if (!accepted) c.index = -1;
  }
  return candidates;
}

void MatchPointsStereo(std::vector<StereoPoint>& left, const std::vector<PointFeature>& right,
                       const std::vector<PointCandidate>& candidates, const HalvedPair& pair, const RowField& rows,
                       const StereoOptions& options, std::atomic<size_t>& begun) {
  const PatchAligner aligner(pair, options.row_sigma_px, rows);
  RowSearch search(pair, rows);
  for (size_t first = begun.fetch_add(kPointsAtATime); first < left.size(); first = begun.fetch_add(kPointsAtATime)) {
    for (size_t i = first; i < std::min(first + kPointsAtATime, left.size()); ++i) {
      const int index = candidates[i].index;
      MatchPoint(left[i], index >= 0 ? &right[static_cast<size_t>(index)] : nullptr, search, aligner, options);
    }
  }
}

void AlignWithRight(const PatchAligner& aligner, double expected_px, const StereoOptions& options,
                    StereoPoint& point) {
  ForgetPartner(point);
  point.is_ambiguous = false;
  point.is_far = false;
  const auto found = aligner.Align(point.left.px, point.left.scale, expected_px);
  if (found && Accept(*found, options.point_min_correlation, options, point)) SetDepth(*found, point);
}

}  // namespace plslam::vo
