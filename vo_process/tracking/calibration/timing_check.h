// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "vo_process/stereo/rolling_shutter.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"

namespace plslam::vo {

/// Estimates, with points and lines, how much later than assumed parts of a moving pair are exposed.
///
/// Two tracked frames some frames apart determine it: with wrong times no rigid motion explains both. Measurements of
/// both frames are (u, v, disparity) of points and of the ends of segments; a point of the first frame is predicted in
/// the second one by the motion in between, and
///
///   (u, v, d)_measured = (u, v, d)_true + late e_late + readout e_readout + offset of the disparities,
///
/// where e_late and e_readout follow from the velocity of the image at the feature, for segments across their direction
/// (`RollingShutter` has the times of rows). The motion of each pair of frames is estimated together with these
/// parameters by robust least squares and eliminated, as in `DisparityCheck`. Pairs of frames are disjoint, and every
/// second one belongs to the other half of the data: an effect of the cameras is the same in both halves.
///
/// Grazing ground ahead of a vehicle biases disparities low in the image, which looks like a readout while it drives
/// straight ahead: in the built-in street, translation shows 45 ms instead of 25 ms. The effects of turning and of
/// translation therefore have a readout each, and only that of turning counts.
class TimingCheck {
 public:
  /// Delay of the right image after the left one; readout time, as turning and translation show it, in seconds; then
  /// the coefficients of the offset of the disparities (`DisparityErrorTerms`).
  static constexpr int kLate = 0;
  static constexpr int kReadoutOfTurning = 1;
  static constexpr int kReadoutOfTranslation = 2;
  static constexpr int kOffset = 3;
  using Parameters = Eigen::Matrix<double, 6, 1>;

  /// An estimate with all data, and whether both halves agree about it.
  struct Estimate {
    double value = 0.0;
    double sigma = 0.0;
    bool halves_agree = false;

    /// Whether the value differs from another one by so many sigmas, and the halves agree about it.
    bool DiffersFrom(double other, double sigmas) const {
      return halves_agree && std::abs(value - other) > sigmas * sigma;
    }
  };

  TimingCheck(const StereoCamera& camera, const RollingShutter& shutter) : camera_(camera), shutter_(shutter) {}

  /// Adds a tracked frame. `velocity` is that of the camera in its own frame, [m/s; rad/s]; `applied` the parameters
  /// that the features are already corrected for; `dt_s` the time since the previous frame.
  void Observe(const TrackedFrame& frame, const SE3& T_odom_c, const Vector6d& velocity, const Parameters& applied,
               double dt_s);

  /// Ends the pair of frames after a frame that was not tracked.
  void Interrupt() { begin_ = {}; }

  /// Returns nullopt before the first pairs of frames.
  std::optional<Estimate> EstimateOf(int parameter) const;
  int64_t n_pairs() const { return n_pairs_; }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.halves_[0], self.halves_[1], self.n_pairs_, self.dt_s_, self.begin_);
  }

 private:
  /// A measured point or end of a segment, and the effect of each parameter on it.
  struct Place {
    Eigen::Vector3d uvd = Eigen::Vector3d::Zero();
    double sigma_px = 1.0;
    double sigma_disparity_px = 1.0;
    /// Change of the disparity by a second of lateness, and of (u, v, disparity) by a second of readout while turning
    /// or moving.
    double by_late_px_s = 0.0;
    Eigen::Vector3d by_turning_px_s = Eigen::Vector3d::Zero();
    Eigen::Vector3d by_translation_px_s = Eigen::Vector3d::Zero();

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.uvd, self.sigma_px, self.sigma_disparity_px, self.by_late_px_s, self.by_turning_px_s,
        self.by_translation_px_s);
    }
  };
  using Effects = Eigen::Matrix<double, 3, 6>;
  using Information = Eigen::Matrix<double, 6, 6>;
  struct Point {
    TrackId landmark_id = -1;
    Place at;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.landmark_id, self.at);
    }
  };
  struct Line {
    TrackId landmark_id = -1;
    Place p;
    Place q;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.landmark_id, self.p, self.q);
    }
  };
  /// Views of one frame, ordered by landmark.
  struct View {
    int64_t n_frames = 0;
    SE3 T_odom_c;
    Parameters applied = Parameters::Zero();
    std::vector<Point> points;
    std::vector<Line> lines;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.n_frames, self.T_odom_c, self.applied, self.points, self.lines);
    }
  };
  /// Normal equations of the parameters, motions eliminated.
  struct Evidence {
    Information information = Information::Zero();
    Parameters vector = Parameters::Zero();
    double squares = 0.0;
    double count = 0.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.information, self.vector, self.squares, self.count);
    }
  };
  using Normal = Eigen::Matrix<double, 12, 13>;
  struct Sum;

  View ViewOf(const TrackedFrame& frame, const SE3& T_odom_c, const Vector6d& velocity,
              const Parameters& applied) const;
  Place PlaceOf(const Eigen::Vector3d& uvd, const Vector6d& velocity, const Eigen::Vector2d* along) const;
  Effects EffectsOn(const Place& place) const;
  void Learn(const View& now);
  void Add(const View& now, const SE3& T_now_before, const Parameters& parameters, Sum& sum) const;
  Information Prior() const;

  StereoCamera camera_;
  RollingShutter shutter_;
  std::array<Evidence, 2> halves_;
  int64_t n_pairs_ = 0;
  double dt_s_ = 0.0;
  View begin_;
};

}  // namespace plslam::vo
