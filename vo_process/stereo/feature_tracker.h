// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/features/feature_extractor.h"
#include "core/features/features.h"
#include "core/features/options.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/stereo/dirt_cells.h"
#include "vo_process/stereo/patch_tracker.h"
#include "vo_process/stereo/rectified_pair.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/stereo/segment_tracker.h"

namespace plslam::vo {

/// Follows features from frame to frame by their grey levels, without detecting or describing them (semi-direct
/// tracking: Forster et al. 2017; PL-SLAM §IX).
///
/// Points and lines of a frame in which they were detected are found in the next frames: predicted from the last frame,
/// then located in the left image by `TrackPatch` and `LocateSegment`; in the right image points by alignment from the
/// expected disparity, lines as in the left one. Patches are those of the first frame, so points do not drift; they
/// change as the slope of the surface, which the first pair showed, lets expect. Only corners and lines with depth are
/// followed, and those that are not found are not looked for again.
///
/// The errors of a point in successive frames are common to all: those of its detection, and of its patch's disparity.
class FeatureTracker {
 public:
  FeatureTracker(const StereoCamera& camera, const StereoOptions& options) : camera_(camera), options_(options) {}

  /// Knowledge of the next frame: the camera was at `T_odom_previous` in the last one, and is expected at `T_odom_now`.
  struct Known {
    RowField rows;
    PairDirt dirt;
    SE3 T_odom_previous;
    SE3 T_odom_now;
    double depth_units_per_m = 0.0;  ///< of the depth map, if the pair has one
  };
  /// Finds the features in the next frame.
  void Track(const RectifiedPair& pair, const Known& known, const RunBoth& run_both);

  /// The features in the last frame.
  StereoFeatures Features() const;

  /// Stops following some features, by how they were seen last.
  template <class PointIsGone, class LineIsGone>
  void RemoveIf(const PointIsGone& point_is_gone, const LineIsGone& line_is_gone) {
    std::erase_if(points_, [&](const FollowedPoint& point) { return point_is_gone(point.seen); });
    std::erase_if(lines_, [&](const FollowedLine& line) { return line_is_gone(line.seen); });
  }

  /// Follows the features with depth of a frame in the next ones. `left` are its `HalvedImages`.
  void Begin(const std::vector<cv::Mat>& left, const StereoFeatures& features);

  /// Sets the pose of that frame, once it is known.
  void SetPose(const SE3& T_odom_c) { T_odom_first_ = T_odom_c; }

  bool empty() const { return points_.empty() && lines_.empty(); }
  /// Features found in the last frame; lines count twice.
  double Weight() const { return static_cast<double>(points_.size() + 2 * lines_.size()); }
  /// The same as a share of those in the first frame.
  double Share() const { return n_begun_ > 0.0 ? Weight() / n_begun_ : 0.0; }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.points_, self.lines_, self.T_odom_first_, self.n_begun_);
  }

 private:
  struct FollowedPoint {
    StereoPoint seen;           ///< in the last frame
    double disparity_px = 0.0;  ///< the last that is known
    StoredPatch patch;
    double first_disparity_px = 0.0;
    Eigen::Vector2d first_slope = Eigen::Vector2d::Zero();  ///< of the disparity, as in `StereoPoint`
    bool is_found = true;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      auto& seen = self.seen;
      a(seen.left.px, seen.left.response, seen.left.angle_rad, seen.left.octave, seen.left.descriptor,
        seen.left.scale, seen.disparity_px, seen.sigma_px, seen.sigma_disparity_px, seen.row_offset_px,
        seen.sigma_row_px, seen.is_ambiguous, seen.is_far, self.disparity_px, self.patch, self.first_disparity_px,
        self.first_slope);
    }
  };
  struct FollowedLine {
    StereoLine seen;  ///< in the last frame
    bool is_found = true;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      auto& seen = self.seen;
      a(seen.left.segment.p, seen.left.segment.q, seen.left.response, seen.left.octave, seen.left.descriptor,
        seen.disparity_p_px, seen.disparity_q_px, seen.sigma_px, seen.sigma_disparity_p_px,
        seen.sigma_disparity_q_px);
    }
  };
  /// Expected motion of the camera, and its expected pose.
  struct Expected {
    SE3 T_now_previous;
    SE3 T_now_odom;
  };
  struct ExpectedPoint {
    PatchExpectation patch;
    double disparity_px = 0.0;
  };

  std::optional<ExpectedPoint> Expect(const Expected& motion, const FollowedPoint& point) const;
  Expected Improved(const Expected& motion, const std::vector<cv::Mat>& left) const;
  std::optional<Expected> ImprovedFrom(const Expected& motion, const std::vector<cv::Mat>& left) const;
  std::optional<Expected> Turned(const Expected& motion, const std::vector<cv::Mat>& left) const;
  bool TrackPoint(const std::vector<cv::Mat>& left, const Expected& motion, FollowedPoint& point) const;
  bool TrackLine(const RectifiedPair& pair, const Known& known, const Expected& motion, StereoLine& line) const;

  StereoCamera camera_;
  StereoOptions options_;
  std::vector<FollowedPoint> points_;
  std::vector<FollowedLine> lines_;
  SE3 T_odom_first_;
  double n_begun_ = 0.0;  ///< weight of the features in the first frame
};

}  // namespace plslam::vo
