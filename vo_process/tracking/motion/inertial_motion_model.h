// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/geometry/imu.h"
#include "core/geometry/up_direction.h"
#include "core/inertial/inertial_filter.h"
#include "core/inertial/preintegration.h"
#include "core/motion/motion_estimator.h"
#include "vo_process/tracking/motion/motion_model.h"

namespace plslam::vo {

/// An inertial sensor as it is mounted on the rectified left camera c.
struct MountedImu {
  SE3 T_imu_c;
  ImuCalibration calibration;
};

/// Returns the sensor of a rig, if it has one. Throws as `Rectify`.
std::optional<MountedImu> MountedImuOf(const RigCalibration& rig);

/// Evidence of why a sensor contradicts the images: sums over motions between measured frames.
struct ImuEvidence {
  double force_m_s = 0.0;  ///< mean specific force times time
  double time_s = 0.0;
  /// Rotations that were seen since the gyroscope's bias is known, and the angles by which the sensed ones differ.
  double compared_turn_rad = 0.0;
  double turn_difference_rad = 0.0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.force_m_s, self.time_s, self.compared_turn_rad, self.turn_difference_rad);
  }
};

/// Predicts by an inertial sensor, and carries the pose through frames that see nothing.
///
/// `InertialFilter` estimates velocity, gravity and biases from the measured poses. It is used as soon as a second of
/// measured frames has determined them, and not while measured poses contradict it: of the last frames' normalised
/// innovations (6 for a consistent sensor) the mean must be below a bound. A contradiction ends when the mean has been
/// well below it for some seconds.
///
/// A frame whose samples have not arrived is left out, and so are those after it until they have: the filter then takes the
/// whole motion with the last measured pose. Samples that are lost, because later ones are there, or that are older than a
/// second, leave the velocity unknown until some poses have shown it; gravity and biases are kept. Only a contradiction
/// and a jump make the filter begin again.
///
/// A sensor that has been seen standing is assumed to stand in the dark as long as its samples are those of a standing
/// one: within the white noise of the angular rate that is its bias, and of the specific force while it was seen.
class InertialMotionModel {
 public:
  explicit InertialMotionModel(const std::optional<MountedImu>& imu)
      : imu_(imu), filter_(imu ? imu->calibration.noise : ImuNoise()) {}

  bool has_sensor() const { return imu_.has_value(); }

  /// Sets the samples since the last frame, which was at `from_ns`, to the next one (both on the clock of the images), and
  /// those before it since `NeededFrom`. A frame that is not later says nothing of motions. `are_measured`: the samples
  /// are neither stuck nor saturated.
  void Expect(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns, bool are_measured = true);
  /// Returns the time from which samples are of use, on the clock of the images, of a next motion from `from_ns` on.
  int64_t NeededFrom(int64_t from_ns) const;
  /// The time of the next frame is not known.
  void ExpectNothing();
  /// Sets those of another model of this sensor, which is as faulty.
  void ExpectAs(const InertialMotionModel& other);

  /// The first frame is at this pose.
  void Start(const SE3& T_odom_c);

  /// Returns a model of the same sensor, with what is known of its biases, for another frame than odom in which the
  /// camera may move: `T_frame_prev` is the pose of the last frame in it.
  InertialMotionModel For(const SE3& T_frame_prev) const;

  /// Agreement of the next frame's pose, measured with this covariance, with the sensor; nullopt without samples, after
  /// a gap until the velocity is known again, and while the sensor contradicts the images.
  std::optional<InertialFilter::Agreement> AgreementWith(const SE3& T_odom_c, const Matrix6d& covariance) const;
  /// The same while the sensor contradicts the images; nullopt if it is known to be faulty.
  std::optional<InertialFilter::Agreement> ContradictedAgreementWith(const SE3& T_odom_c,
                                                                     const Matrix6d& covariance) const;

  /// Returns the prediction for that frame; `own` if the sensor is not used.
  MotionPrediction Predict(const MotionPrediction& own) const;

  /// The frame was measured, with the covariance of the right perturbation of its pose given the landmarks. `is_sure`:
  /// by its features alone. `jumped`: the pose does not continue those before.
  void Observe(const SE3& T_odom_c, const Matrix6d& covariance, bool is_sure, bool jumped);

  /// Odom may have turned by the error of the motion to the measured frame, whose covariance is this.
  void Drift(const Matrix6d& motion_covariance);

  /// The frame was not measured.
  void Miss();

  /// The sensor is not used while it is known to be faulty.
  void SetFaulty(bool is_faulty) { is_faulty_ = is_faulty; }

  /// A pose of the camera in odom, with the covariance of its right perturbation given the landmarks.
  struct MeasuredPose {
    SE3 T_odom_c;
    Matrix6d covariance = Matrix6d::Zero();
  };
  /// Returns the pose of the next frame by the sensor alone as a prior for its estimation. `before` is the estimated pose
  /// of the last frame; nullopt if the sensor is not used, or if `seen`, the pose by its features, contradicts it.
  std::optional<MotionPrior> PriorFrom(const MeasuredPose& before, const MeasuredPose& seen) const;

  /// Whether the sensor carries the pose of a frame that sees nothing: its prediction is still good to half a metre and
  /// five degrees (sigmas).
  bool CanCarry() const;

  /// The vertical from the camera at the last frame, with the error of the mounting; nullopt if the sensor is not used.
  std::optional<UpDirection> Up() const;

  /// Mean normalised innovation of the last frames over its expectation: 1 for a consistent sensor.
  double normalised_innovation() const { return innovation_; }
  /// Returns whether the sensor has agreed with measured poses for long enough to know gravity and biases.
  bool IsHealthy() const;
  /// Returns whether it also knows the velocity, to predict motions.
  bool IsTrusted() const;
  const InertialFilter& filter() const { return filter_; }
  /// Returns one sentence on a sensor that contradicts the images without a known fault, with the number that shows it;
  /// empty for a healthy one, and before some seconds of measured frames.
  std::string Complaint() const;

  /// The state after a frame, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.filter_, self.knows_bias_, self.measured_s_, self.unmeasured_s_, self.innovation_, self.n_contradicting_,
      self.evidence_, self.was_observed_, self.T_odom_observed_, self.mean_force_m_s2_, self.standing_s_,
      self.standing_force_m_s2_, self.is_faulty_, self.reach_, self.covariance_observed_, self.is_contradicting_,
      self.agreeing_s_);
  }

 private:
  void Begin(const SE3& T_odom_imu, const Matrix6d& covariance);
  void ContinueAt(const SE3& T_odom_imu, const Matrix6d& covariance, int64_t t_ns);
  void CatchUp();
  void FallBehind();
  void Take(const SE3& T_odom_imu, const Matrix6d& covariance, bool jumped);
  void Integrate(const ImuBias& bias);
  void Measure(const SE3& T_odom_imu, const Matrix6d& covariance);
  void AddEvidence(const SE3& T_previmu_imu);
  void LearnStanding(const SE3& T_previmu_imu);
  bool IsQuiet() const;
  bool KnowsVelocity() const;
  void AddInnovation(double normalised_innovation);
  /// Returns a state of the filter after the motion to the next frame, which must be known.
  InertialFilter Propagated(InertialFilter filter) const;
  Matrix6d MeasuredCovariance(const Matrix6d& covariance) const;
  /// Motion of the camera since the last measured frame and its covariance, as of this state of the filter.
  SE3 CameraMotion(const InertialFilter& filter) const;
  Matrix6d CameraCovariance(const InertialFilter& filter) const;

  std::optional<MountedImu> imu_;
  InertialFilter filter_;
  /// The motion to the next frame, the samples that it is integrated from, and their mean specific force.
  std::optional<Preintegration> motion_;
  struct Interval {
    std::vector<ImuSample> samples;
    int64_t from_ns = 0;  ///< on the clock of the sensor
    int64_t to_ns = 0;
    bool is_measured = false;
  } interval_;
  Eigen::Vector3d mean_force_m_s2_ = Eigen::Vector3d::Zero();
  bool knows_bias_ = false;
  double measured_s_ = 0.0;    ///< time of measured motions since the filter began
  double unmeasured_s_ = 0.0;  ///< time since the last measured frame
  double innovation_ = 1.0;
  bool is_contradicting_ = false;
  double agreeing_s_ = 0.0;  ///< time for which the mean innovation has been well below its bound
  int n_contradicting_ = 0;  ///< successive measured poses that contradict the filter
  ImuEvidence evidence_;
  /// Time for which the sensor has been seen standing, and the mean specific force in it.
  double standing_s_ = 0.0;
  Eigen::Vector3d standing_force_m_s2_ = Eigen::Vector3d::Zero();
  bool is_faulty_ = false;
  bool is_not_later_ = false;  ///< whether the next frame is at the time of the last one, or before
  /// How far the filter has come.
  struct Reach {
    /// Whether it lacks the motions since `t_ns` (clock of the sensor), and their samples are lost.
    bool is_behind = false;
    bool misses_samples = false;
    int64_t t_ns = 0;
    double known_s = 0.0;  ///< time of measured motions since the velocity was unknown

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.is_behind, self.misses_samples, self.t_ns, self.known_s);
    }
  } reach_;
  bool was_observed_ = false;  ///< whether the last frame was measured
  SE3 T_odom_observed_;        ///< pose of the sensor in it
  Matrix6d covariance_observed_ = Matrix6d::Zero();
};

}  // namespace plslam::vo
