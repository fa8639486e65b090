// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"
#include "core/run/run_counters.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/tracking/tracked_frame.h"

namespace plslam::vo {

/// Estimates, while driving, by how much later than the left image the right one is taken.
///
/// The row of a match is lower in the right image by the field of the rig (`RowField`), and by what the point moves
/// down between the two images:
///
///   v_right - v_left = field(u, v) + (late + uneven y) dv/dt,   y from -1 to 1 over the image,
///
/// where dv/dt is seen by following the point over the frame before and the frame after. `uneven` is not zero where
/// the two cameras read their rows at different speeds. The field stays while motions come and go, so all are found
/// together: weighted least squares (Huber) in which the past fades. Believed only where it is large enough to matter
/// and certain.
class SyncCheck {
 public:
  explicit SyncCheck(const StereoCamera& camera) : camera_(camera) {}

  /// What is believed; 0 until it is significant, and as long as it is less than a twentieth of a frame.
  double late_s() const { return is_late_ ? solution_(kLate) : 0.0; }

  /// The same as a share of the time between the last frames.
  double late_frames() const { return interval_s_ > 0.0 ? late_s() / interval_s_ : 0.0; }

  /// Late by so much of a frame that where the camera was at the time of the right image is a guess: what is found
  /// with such a pair is not sure.
  bool is_far_off() const { return std::abs(late_frames()) > kMostLateMadeUpFor_frames; }

  /// By how much longer the right camera takes to read its image than the left one (rolling shutters that are not
  /// alike); 0 until it is significant.
  double longer_readout_s() const { return is_uneven_ ? 2.0 * solution_(kUneven) : 0.0; }

  /// What is to be expected of a pair, with the motion `T_prev_c` within the `dt_s` before it.
  PairSkew SkewOf(const SE3& T_prev_c, double dt_s) const;

  /// Learns from a frame that was tracked, `dt_s` after the one before: of the matches of that one, whose points are
  /// now seen to move on. True where `late_s` becomes zero by it, or is not zero any more.
  bool Observe(const TrackedFrame& frame, double dt_s);

  /// After a frame that was not tracked.
  void Interrupt() { seen_.clear(); }

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.is_late_, self.is_uneven_, self.information_, self.vector_, self.solution_, self.squares_, self.count_,
      self.late_matched_s_, self.n_frames_, self.interval_s_, self.seen_);
  }

 private:
  static constexpr int kLate = 6;
  static constexpr int kUneven = 7;
  using Vector8d = Eigen::Matrix<double, 8, 1>;
  using Matrix8d = Eigen::Matrix<double, 8, 8>;

  /// A landmark in the frame before.
  struct Seen {
    int64_t landmark_id = -1;
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    /// Pixels a second down, since the frame before that; whether it was seen there.
    double down_px_s = 0.0;
    bool has_moved = false;
    /// Of its match: `RowObservation`, variance 0 where the row is not told.
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

  const Seen* FindSeen(int64_t landmark_id) const;
  std::vector<Equation> EquationsOf(const TrackedFrame& frame, double dt_s) const;
  void Learn(const std::vector<Equation>& equations, double dt_s);
  void Remember(const TrackedFrame& frame, double dt_s);
  /// What is believed from now on.
  void Decide(const std::vector<Equation>& equations, double dt_s);

  StereoCamera camera_;
  bool is_late_ = false;
  bool is_uneven_ = false;
  /// Normal equations, and their solution: six coefficients of the field in pixels, lateness and unevenness in
  /// seconds.
  Matrix8d information_ = Matrix8d::Zero();
  Vector8d vector_ = Vector8d::Zero();
  Vector8d solution_ = Vector8d::Zero();
  /// Of the residuals: sum of their squares in standard deviations, and number, the past fading.
  double squares_ = 0.0;
  double count_ = 0.0;
  /// The lateness that the matches of the past were looked for with.
  double late_matched_s_ = 0.0;
  int64_t n_frames_ = 0;
  double interval_s_ = 0.0;
  /// Ordered by landmark.
  std::vector<Seen> seen_;
};

}  // namespace plslam::vo
