// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/imu.h"

namespace plslam {

/// The rotation of a camera between two frames as the images show it.
struct SeenTurn {
  int64_t from_ns = 0;  ///< both on the clock of the sensor, as its stated time offset gives it
  int64_t to_ns = 0;
  /// Rotation vector in the frame of the sensor, as its stated mounting gives it, rad.
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  /// Variance of each of its components by the images, rad^2.
  double variance_rad2 = 0.0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.from_ns, self.to_ns, self.turn_rad, self.variance_rad2);
  }
};

/// How the sensor's axes lie to the stated ones: `sensed = matrix * seen`.
struct AxisHypothesis {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  /// Twice the negative logarithm of its prior probability.
  double penalty = 0.0;
};

/// The explanation of the sensed rates that is most likely given the seen turns.
struct TurnFit {
  /// Index of the hypothesis; the number of hypotheses for any other rotation.
  uint64_t axes = 0;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  /// Number of other hypotheses that are about as likely.
  int n_rivals = 0;
  /// Sensed over seen turns; exactly 1 if that explains them.
  double scale = 1.0;
  /// Delay of the sensor's stamps, s, beyond the stated one, and its sigma; 0 if none is significant.
  double delay_s = 0.0;
  double delay_sigma_s = 0.0;
  Eigen::Vector3d bias_rad_s = Eigen::Vector3d::Zero();
  /// Turns that were compared, and the rms of what the fit leaves, each axis, rad a square root of a second.
  double pairs = 0.0;
  double residual_rad_sqrt_s = 0.0;
  /// Twice the logarithm of the ratio of probabilities of this explanation and of the description as stated.
  double evidence = 0.0;
  /// Rms of the seen turns over their sigma, and of their differences from a constant rate.
  double excitation = 0.0;
  double variation = 0.0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.axes, self.matrix, self.n_rivals, self.scale, self.delay_s, self.delay_sigma_s, self.bias_rad_s,
      self.pairs, self.residual_rad_sqrt_s, self.evidence, self.excitation, self.variation);
  }
};

/// Compares the turns that a gyroscope senses with those seen by the images.
///
/// Over an interval between frames, sensed at a delay l, the integral of the rates is `scale * A * turn + bias * dt`.
/// For each l of a grid the sums of products of both are kept (forgotten over `kMemory_s`), from which the best bias and
/// scale of each hypothesis of the axes A, and its sum of squares, follow in closed form: Wahba's problem ("A Least
/// Squares Estimate of Satellite Attitude", 1965) over a finite set of rotations and reflections, each with its prior.
/// A further hypothesis is the best of all rotations (Kabsch 1976). Both turns have errors, so sums of squares are divided
/// by the variance of their difference: that of the gyroscope plus scale^2 times that of the images. The minimum over l
/// is refined by a parabola, whose curvature gives the sigma. Costs are divided by what the best explanation leaves.
class TurnAlignment {
 public:
  /// Largest delay that is searched, either way.
  static constexpr double kMostDelay_s = 0.30;
  static constexpr double kMemory_s = 10.0;

  /// Takes the next sample; those that are not later than one before are ignored.
  void Add(const ImuSample& sample);
  /// Takes the next seen turn. Intervals longer than a second are ignored: the integral of the rates is a rotation for
  /// small angles only.
  void Add(const SeenTurn& turn);

  /// Returns the most likely explanation; `axes` must contain the identity first. `noise_rad_s_sqrt_hz` is the white noise
  /// density of the rates as they are.
  TurnFit Fit(const std::vector<AxisHypothesis>& axes, double noise_rad_s_sqrt_hz) const;

  /// The state, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.integral_, self.now_, self.last_rate_rad_s_, self.has_begun_, self.pending_, self.lags_, self.dt2_,
      self.seen_dt_, self.seen2_, self.weighted_dt_, self.pairs_);
  }

 private:
  /// The integral of the rates from the beginning to a time.
  struct Integral {
    int64_t t_ns = 0;
    Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
    /// Whether samples before it are missing.
    bool after_gap = false;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.t_ns, self.turn_rad, self.after_gap);
    }
  };
  /// Weighted sums for one delay.
  struct Lag {
    Eigen::Vector3d sensed_dt = Eigen::Vector3d::Zero();
    Eigen::Matrix3d sensed_seen = Eigen::Matrix3d::Zero();
    double sensed2 = 0.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.sensed_dt, self.sensed_seen, self.sensed2);
    }
  };
  /// Sums of products about the best bias.
  struct Moments {
    Eigen::Matrix3d sensed_seen = Eigen::Matrix3d::Zero();
    double sensed2 = 0.0;
    double seen2 = 0.0;
    double ratio2 = 0.0;  ///< of sensed over seen turns with the bias, squared
  };
  class Search;

  bool HasAllSamples(int64_t from_ns, int64_t to_ns) const;
  Eigen::Vector3d IntegralAt(int64_t t_ns) const;
  void Compare(const SeenTurn& turn);
  Moments At(size_t lag) const;

  std::deque<Integral> integral_;
  Integral now_;  ///< up to the newest sample
  Eigen::Vector3d last_rate_rad_s_ = Eigen::Vector3d::Zero();
  bool has_begun_ = false;
  /// Turns whose later samples have not arrived.
  std::deque<SeenTurn> pending_;
  std::vector<Lag> lags_;
  /// Sums that are the same for all delays.
  double dt2_ = 0.0;
  Eigen::Vector3d seen_dt_ = Eigen::Vector3d::Zero();
  double seen2_ = 0.0;
  double weighted_dt_ = 0.0;
  double pairs_ = 0.0;
};

}  // namespace plslam
