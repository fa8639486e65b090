// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/run/run_counters.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/tracking/calibration/timing_check.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"

namespace plslam::vo {

/// Estimates the delay of the right image after the left one, while driving.
///
/// The row of a match in the right image is lower by the field of the rig (`RowField`), and by the downward motion of
/// the point between the two images:
///
///   v_right - v_left = field(u, v) + (late + uneven y) dv/dt,   y from -1 to 1 over the image,
///
/// where dv/dt is measured by tracking the point over the previous and the next frame. `uneven` is not zero if the two
/// cameras read their rows at different speeds. The field is constant while motions change, so all are estimated
/// together by weighted least squares (Huber) with fading memory. The result is applied only if it is large enough to
/// matter and significant. Where few corners measure rows, motions over several frames show the delay (`TimingCheck`). The
/// measure that is significant first is used.
class SyncCheck {
 public:
  explicit SyncCheck(const StereoCamera& camera) : camera_(camera) {}

  /// The applied delay; 0 until it is significant, and below a twentieth of a frame.
  double late_s() const { return is_late_by_motion_ ? late_by_motion_s_ : is_late_ ? solution_(kLate) : 0.0; }

  /// The same as a share of the time between the last frames.
  double late_frames() const { return interval_s_ > 0.0 ? late_s() / interval_s_ : 0.0; }

  /// Whether the delay is so large that the camera's pose at the time of the right image is uncertain, and with it the
  /// results from such a pair.
  bool is_far_off() const { return std::abs(late_frames()) > kLargestCompensatedDelay_frames; }

  /// Readout time of the right camera minus that of the left one (rolling shutters with different speeds); 0 until it
  /// is significant.
  double longer_readout_s() const { return is_uneven_ ? 2.0 * solution_(kUneven) : 0.0; }

  /// Returns the predicted skew of a pair, given the motion `T_prev_c` in the `dt_s` before it.
  PairSkew SkewOf(const SE3& T_prev_c, double dt_s) const;

  /// Learns from a tracked frame, `dt_s` after the previous one: from the matches of that one, whose points are now
  /// seen to move. `by_motion` is the delay that motions show, if known. Returns whether `late_s` has become zero or
  /// nonzero.
  bool Observe(const TrackedFrame& frame, double dt_s,
               const std::optional<TimingCheck::Estimate>& by_motion = std::nullopt);

  /// Call after a frame that was not tracked.
  void Interrupt() { seen_.clear(); }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.is_late_, self.is_late_by_motion_, self.late_by_motion_s_, self.is_uneven_, self.information_,
      self.vector_, self.solution_, self.squares_, self.count_, self.late_matched_s_, self.n_frames_,
      self.interval_s_, self.seen_);
  }

 private:
  static constexpr int kLate = 6;
  static constexpr int kUneven = 7;
  using Vector8d = Eigen::Matrix<double, 8, 1>;
  using Matrix8d = Eigen::Matrix<double, 8, 8>;

  /// A landmark in the previous frame.
  struct Seen {
    TrackId landmark_id = -1;
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    /// Downward velocity in pixels per second, from the frame before that, and whether it was seen there.
    double down_px_s = 0.0;
    bool has_moved = false;
    /// From the `RowObservation` of its match; variance 0 if it has none.
    Eigen::Vector2d place_px = Eigen::Vector2d::Zero();
    double offset_px = 0.0;
    double variance_px2 = 0.0;
    double sharing = 1.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.landmark_id, self.px, self.down_px_s, self.has_moved, self.place_px, self.offset_px, self.variance_px2,
        self.sharing);
    }
  };
  struct Equation {
    Vector8d terms;
    double offset_px = 0.0;
    double variance_px2 = 1.0;
    double sharing = 1.0;
  };

  const Seen* FindSeen(TrackId landmark_id) const;
  std::vector<Equation> EquationsOf(const TrackedFrame& frame, double dt_s) const;
  void Learn(const std::vector<Equation>& equations, double dt_s);
  void Remember(const TrackedFrame& frame, double dt_s);
  void UseMotion(const TimingCheck::Estimate& by_motion, double dt_s);
  /// Decides which estimates are applied.
  void Decide(const std::vector<Equation>& equations, double dt_s);

  StereoCamera camera_;
  /// Whether rows show a delay, and whether motions do.
  bool is_late_ = false;
  bool is_late_by_motion_ = false;
  double late_by_motion_s_ = 0.0;
  bool is_uneven_ = false;
  /// Normal equations, and their solution: six coefficients of the field in pixels, lateness and unevenness in seconds.
  Matrix8d information_ = Matrix8d::Zero();
  Vector8d vector_ = Vector8d::Zero();
  Vector8d solution_ = Vector8d::Zero();
  /// Squared whitened residuals and their number, summed with fading memory.
  double squares_ = 0.0;
  double count_ = 0.0;
  /// The delay with which past matches were searched.
  double late_matched_s_ = 0.0;
  int64_t n_frames_ = 0;
  double interval_s_ = 0.0;
  /// Ordered by landmark.
  std::vector<Seen> seen_;
};

}  // namespace plslam::vo
