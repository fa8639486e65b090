// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/imu.h"
#include "core/geometry/se3.h"
#include "core/inertial/sample_checks.h"
#include "core/inertial/turn_alignment.h"

namespace plslam {

/// One fault of an inertial sensor or of its description.
struct SensorFinding {
  enum class Fault { kForceUnit, kRateUnit, kAxes, kTimeOffset, kStuck, kNoise, kSaturation, kGaps, kRate };

  Fault fault = Fault::kForceUnit;
  /// Whether estimates with such a sensor are worse than without it.
  bool is_harmful = false;
  /// Part of a sentence with the number that shows the fault, and what remedies it.
  std::string text;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.fault, self.is_harmful, self.text);
  }
};

/// Finds out what is wrong with an inertial sensor, or with its description, from its samples and the motions that the
/// images show.
///
/// Units, mounting and time offset follow from the turns (`TurnAlignment`), among hypotheses that drivers and
/// calibrations produce: signed permutations of the axes, extrinsics the wrong way round, and any rotation. The mean
/// specific force gives its unit; `SampleChecks` the rest. A harmful fault that was found ends when it has been below
/// `kEnds` of its bounds for five seconds, so that one near a bound does not come and go. The state is bounded, and
/// depends on the input alone.
class SensorDiagnosis {
 public:
  static constexpr double kEnds = 0.6;

  /// `T_imu_c` is the pose of the camera in the sensor as stated.
  SensorDiagnosis(const ImuCalibration& stated, const SE3& T_imu_c);

  /// Takes the samples up to a frame, in order of time, on the clock of the sensor; earlier ones and those after the
  /// first one that is not before the frame are ignored. Returns whether they are measurements: neither stuck nor at
  /// the end of a range.
  bool Add(std::span<const ImuSample> samples, int64_t frame_ns);
  /// Takes the motion of the camera between two frames (clock of the sensor as its stated offset gives it), measured by
  /// the images alone, with the covariance of its right perturbation.
  void Add(int64_t from_ns, int64_t to_ns, const SE3& T_prev_c, const Matrix6d& covariance);

  /// The faults found, the most important first. They are updated a few times a second.
  const std::vector<SensorFinding>& findings() const { return findings_; }
  /// Whether one of them is harmful.
  bool IsHarmful() const;
  /// Whether they have been the same for a second.
  bool HasConverged() const { return same_s_ >= 1.0; }
  /// The last comparison of turns.
  const TurnFit& fit() const { return fit_; }
  const SampleChecks& samples() const { return samples_; }
  /// Time of compared motions.
  double time_s() const { return time_s_; }

  /// The state, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.samples_, self.turns_, self.findings_, self.fit_, self.newest_ns_, self.has_samples_, self.time_s_,
      self.n_pairs_, self.moves_, self.same_s_, self.held_, self.diagnosed_s_);
  }

 private:
  /// A harmful fault that was found, and the time for which it has not been found again.
  struct Held {
    SensorFinding finding;
    double absent_s = 0.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.finding, self.absent_s);
    }
  };

  void Diagnose();
  void HoldHarmful(double dt_s);
  bool IsHeld(SensorFinding::Fault fault) const;
  /// Returns the bound on a value of a fault.
  double Bound(SensorFinding::Fault fault, double bound) const { return IsHeld(fault) ? kEnds * bound : bound; }
  void CheckForces();
  void CheckTurns();
  void CheckSamples();
  bool IsStuck() const;
  void Report(SensorFinding::Fault fault, bool is_harmful, std::string text);
  std::string AxesText() const;

  ImuCalibration stated_;
  SE3 T_imu_c_;
  std::vector<AxisHypothesis> axes_;
  /// Number of the first hypotheses that are inverse extrinsics.
  size_t n_inverse_ = 0;

  SampleChecks samples_;
  TurnAlignment turns_;
  std::vector<SensorFinding> findings_;
  TurnFit fit_;
  int64_t newest_ns_ = 0;
  bool has_samples_ = false;
  double time_s_ = 0.0;
  int n_pairs_ = 0;
  std::vector<Held> held_;
  double diagnosed_s_ = 0.0;  ///< `time_s_` at the last diagnosis
  double same_s_ = 0.0;       ///< time since other faults were found
  bool moves_ = false;        ///< whether the last measured motion was not that of a standing camera
};

}  // namespace plslam
