// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/inertial_motion_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/geometry/hypot.h"
#include "core/geometry/rectification.h"
#include "core/geometry/symmetric.h"
#include "core/motion/robust.h"

namespace plslam::vo {
namespace {

// Time of measured frames after which velocity, gravity and biases are used.
constexpr double kFirstUse_s = 1.0;
// Longest time for which the filter waits for samples, and the sigma up to which a velocity is known after it.
constexpr uint64_t kLongestBehind_ns = 1'000'000'000;
constexpr double kKnownVelocity_m_s = 0.1;
// Errors of measured poses that their covariance lacks, because they are the same in successive frames (landmarks,
// calibration): a filter that takes them for white noise would believe its velocity too much.
constexpr double kCommonVariance = 4.0;
constexpr double kCommon_m = 0.001;
constexpr double kCommon_rad = 0.02 * kRadPerDeg;
// Bound on the innovation of a single pose, above which it is not used, and number of successive such poses after which
// the filter begins again.
constexpr double kGate = 60.0;
constexpr int kMostContradicting = 5;
// Bound on the mean normalised innovation over its expectation, and the number of frames of that mean.
constexpr double kHealthy = 4.0;
constexpr double kMeanFrames = 20.0;
// Bound below which, for how long, it ends a contradiction.
constexpr double kAgreeing = 0.6 * kHealthy;
constexpr double kAgreeing_s = 5.0;
// Sigmas up to which the sensor carries a pose.
constexpr double kFarthest_m = 0.5;
constexpr double kFarthest_rad = 5.0 * kRadPerDeg;
// Errors of a prediction, however good the sensor is: stamps are off by a part of a millisecond, and landmarks move when
// the map is corrected.
constexpr double kPrediction_m = 0.004;
constexpr double kPrediction_rad = 0.1 * kRadPerDeg;
// Errors of the motion between two frames as a measurement. The translation contains the velocity, which comes from the
// poses themselves, with the errors that they have in common: given more weight, it makes paths worse (docs/lab/imu.md).
constexpr double kMotion_m = 0.02;
constexpr double kMotion_rad = 0.002 * kRadPerDeg;
// Norm of the normalised residual of that measurement at which its loss becomes linear: its expectation.
constexpr double kPriorDelta = 2.45;

// Motion between two frames below which the camera is seen standing, the time for which it must, and the sigma of its
// velocity then.
constexpr double kStanding_m = 0.003;
constexpr double kStanding_rad = 0.05 * kRadPerDeg;
constexpr double kStandingRate_rad_s = 0.05 * kRadPerDeg;
constexpr double kStandingSeen_s = 0.5;
constexpr double kStanding_m_s = 0.003;
// Sigmas of the white noise, of means over a frame, within which samples are those of a standing sensor.
constexpr double kQuietSigmas = 5.0;

// Share of the published variance of a motion by which odom may have turned: the published one is 10 to 20 times larger,
// because errors that frames have in common are to be added up over 20 frames (MotionUncertainty).
constexpr double kMotionAlone = 0.1;

// Rotation by an error of the bias up to which a motion is linear in it, and the number of times that a motion is
// integrated.
constexpr double kLinear_rad = 0.01;
constexpr int kMostPasses = 4;

// Sigma of the orientation of a sensor relative to the camera.
constexpr double kMounting_rad = 0.2 * kRadPerDeg;

// Time of measured motions after which a contradiction is reported: faults with a name are found in less.
constexpr double kLeastEvidence_s = 6.0;
// Rotation above which the relative difference between sensed and seen ones is known, and that below which a sensor is
// mounted as stated.
constexpr double kLeastTurn_rad = 0.05;
constexpr double kSameTurn = 0.05;
// Mean specific force below which it is in g.
constexpr double kWeakGravity_m_s2 = 3.0;

Matrix6d Isotropic(double translation_m, double rotation_rad) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(translation_m), Eigen::Vector3d::Constant(rotation_rad);
  return sigma.cwiseAbs2().asDiagonal();
}

/// The nearest matrix without negative eigenvalues.
Matrix6d Positive(const Matrix6d& covariance) {
  const auto [values, vectors] = EigenOf<6>(0.5 * (covariance + covariance.transpose()));
  return vectors * values.cwiseMax(0.0).asDiagonal() * vectors.transpose();
}

double LargestSigma(const Matrix6d& covariance, int first) {
  return std::sqrt(covariance.diagonal().segment<3>(first).maxCoeff());
}

}  // namespace

std::optional<MountedImu> MountedImuOf(const RigCalibration& rig) {
  if (!rig.imu) return std::nullopt;
  const SE3 T_l_c(Rectify(rig).q_l_c, Eigen::Vector3d::Zero());
  return MountedImu{rig.imu->T_b_imu.Inverse() * rig.left.T_b_cam * T_l_c, *rig.imu};
}

void InertialMotionModel::Expect(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns,
                                 bool are_measured) {
  motion_.reset();
  is_not_later_ = from_ns >= to_ns;
  if (!imu_ || is_not_later_) return;
  const int64_t offset_ns = imu_->calibration.offset_ns();
  const std::span<const ImuSample> needed =
      SamplesOfMotion(samples, NeededFrom(from_ns) - offset_ns, to_ns - offset_ns);
  interval_ = {{needed.begin(), needed.end()}, from_ns - offset_ns, to_ns - offset_ns, are_measured};
  if (reach_.is_behind) {
    CatchUp();
  } else {
    reach_.t_ns = interval_.from_ns;
    reach_.misses_samples = false;
  }
  if (!are_measured) return;
  Integrate(filter_.state().bias);
  if (!motion_) return;
  mean_force_m_s2_.setZero();
  const std::span<const ImuSample> own = SamplesOfMotion(interval_.samples, interval_.from_ns, interval_.to_ns);
  for (const ImuSample& sample : own) mean_force_m_s2_ += sample.force_m_s2 / static_cast<double>(own.size());
}

int64_t InertialMotionModel::NeededFrom(int64_t from_ns) const {
  if (!imu_ || !reach_.is_behind || reach_.misses_samples) return from_ns;
  const int64_t filter_ns = reach_.t_ns + imu_->calibration.offset_ns();
  const bool is_recent =
      filter_ns < from_ns && static_cast<uint64_t>(from_ns) - static_cast<uint64_t>(filter_ns) <= kLongestBehind_ns;
  return is_recent ? filter_ns : from_ns;
}

void InertialMotionModel::ExpectNothing() {
  motion_.reset();
  is_not_later_ = false;
  interval_ = {};
}

void InertialMotionModel::Integrate(const ImuBias& bias) {
  motion_ = Preintegrate(interval_.samples, interval_.from_ns, interval_.to_ns, imu_->calibration.noise, bias);
}

void InertialMotionModel::ExpectAs(const InertialMotionModel& other) {
  interval_ = other.interval_;
  is_faulty_ = other.is_faulty_;
  is_not_later_ = other.is_not_later_;
  motion_.reset();
  if (imu_ && reach_.is_behind && !is_not_later_) CatchUp();
  motion_ = other.motion_;
  mean_force_m_s2_ = other.mean_force_m_s2_;
}

/// Brings the filter to the last frame, if samples since its time have arrived, or if they are lost, because those of the
/// next motion have.
void InertialMotionModel::CatchUp() {
  const Interval next = interval_;
  const int64_t offset_ns = imu_->calibration.offset_ns();
  if (NeededFrom(next.from_ns + offset_ns) < next.from_ns + offset_ns) {
    interval_.from_ns = reach_.t_ns;
    interval_.to_ns = next.from_ns;
    Integrate(filter_.state().bias);
  }
  if (motion_) {
    reach_.is_behind = false;
    if (was_observed_) {
      Take(T_odom_observed_, covariance_observed_, false);
    } else {
      filter_.Propagate(*motion_);
      unmeasured_s_ += motion_->dt_s();
    }
    reach_.t_ns = next.from_ns;
  } else if (was_observed_ && next.is_measured &&
             Preintegrate(next.samples, next.from_ns, next.to_ns, imu_->calibration.noise, filter_.state().bias)) {
    ContinueAt(T_odom_observed_, covariance_observed_, next.from_ns);
  }
  motion_.reset();
  interval_ = next;
}

/// The motion to a frame is not known.
void InertialMotionModel::FallBehind() {
  reach_.is_behind = true;
  reach_.misses_samples = reach_.misses_samples || !interval_.is_measured;
  standing_s_ = 0.0;
}

void InertialMotionModel::Start(const SE3& T_odom_c) {
  if (!imu_) return;
  T_odom_observed_ = T_odom_c * imu_->T_imu_c.Inverse();
  was_observed_ = true;
}

InertialMotionModel InertialMotionModel::For(const SE3& T_frame_prev) const {
  InertialMotionModel other = *this;
  if (!imu_ || !motion_) return other;
  other.Start(T_frame_prev);
  other.Begin(other.T_odom_observed_, MeasuredCovariance(Matrix6d::Zero()));
  other.innovation_ = 1.0;
  other.is_contradicting_ = false;
  return other;
}

InertialFilter InertialMotionModel::Propagated(InertialFilter filter) const {
  filter.Propagate(*motion_);
  return filter;
}

/// Covariance of a measured pose of the sensor from that of the camera's.
Matrix6d InertialMotionModel::MeasuredCovariance(const Matrix6d& covariance) const {
  const Matrix6d A = imu_->T_imu_c.Adjoint();
  return A * (kCommonVariance * covariance + Isotropic(kCommon_m, kCommon_rad)) * A.transpose();
}

std::optional<InertialFilter::Agreement> InertialMotionModel::AgreementWith(const SE3& T_odom_c,
                                                                            const Matrix6d& covariance) const {
  const bool lost_velocity = reach_.known_s < measured_s_ && !KnowsVelocity();
  if (is_contradicting_ || lost_velocity) return std::nullopt;
  return ContradictedAgreementWith(T_odom_c, covariance);
}

std::optional<InertialFilter::Agreement> InertialMotionModel::ContradictedAgreementWith(
    const SE3& T_odom_c, const Matrix6d& covariance) const {
  if (!imu_ || !motion_ || is_faulty_ || reach_.is_behind) return std::nullopt;
  const bool is_first = !filter_.has_begun();
  if (is_first && !was_observed_) return std::nullopt;
  const InertialFilter next = Propagated(is_first ? For(T_odom_observed_ * imu_->T_imu_c).filter_ : filter_);
  return next.AgreementWith(T_odom_c * imu_->T_imu_c.Inverse(), MeasuredCovariance(covariance));
}

bool InertialMotionModel::KnowsVelocity() const {
  return reach_.known_s >= kFirstUse_s || filter_.VelocitySigma() < kKnownVelocity_m_s;
}

bool InertialMotionModel::IsTrusted() const { return IsHealthy() && !reach_.is_behind && KnowsVelocity(); }

bool InertialMotionModel::IsHealthy() const {
  return filter_.has_begun() && !is_faulty_ && measured_s_ >= kFirstUse_s && !is_contradicting_ &&
         evidence_.force_m_s >= kWeakGravity_m_s2 * evidence_.time_s;
}

SE3 InertialMotionModel::CameraMotion(const InertialFilter& filter) const {
  return imu_->T_imu_c.Inverse() * filter.Motion() * imu_->T_imu_c;
}

Matrix6d InertialMotionModel::CameraCovariance(const InertialFilter& filter) const {
  const Matrix6d A = imu_->T_imu_c.Inverse().Adjoint();
  return A * filter.MotionCovariance() * A.transpose();
}

MotionPrediction InertialMotionModel::Predict(const MotionPrediction& own) const {
  if (!motion_ || !IsTrusted()) return own;
  const InertialFilter next = Propagated(filter_);
  const SE3 before = CameraMotion(filter_), after = CameraMotion(next);
  const Matrix6d covariance_before = CameraCovariance(filter_);
  MotionPrediction prediction = own;
  prediction.T_prev_c = before.Inverse() * after;
  prediction.since_measured = CameraCovariance(next) + Isotropic(kPrediction_m, kPrediction_rad);
  const Matrix6d grown =
      *prediction.since_measured - ComposeCovariance(covariance_before, prediction.T_prev_c, Matrix6d::Zero());
  prediction.covariance = unmeasured_s_ == 0.0 ? *prediction.since_measured : Positive(grown);
  prediction.is_reliable = prediction.is_near = true;
  prediction.by_robot = true;
  return prediction;
}

std::optional<MotionPrior> InertialMotionModel::PriorFrom(const MeasuredPose& before,
                                                          const MeasuredPose& seen) const {
  if (!motion_ || !IsTrusted() || unmeasured_s_ > 0.0) return std::nullopt;
  const InertialFilter next = Propagated(filter_);
  const SE3 T_prev_c = CameraMotion(filter_).Inverse() * CameraMotion(next);
  const SE3 T_odom_predicted = before.T_odom_c * T_prev_c;
  const Matrix6d covariance =
      ComposeCovariance(before.covariance, T_prev_c, CameraCovariance(next)) + Isotropic(kMotion_m, kMotion_rad);
  const Vector6d off = (T_odom_predicted.Inverse() * seen.T_odom_c).Log();
  const double chi2 = SquaredMahalanobis<6>(off, covariance + seen.covariance);
  if (chi2 > kExpectedChi2) return std::nullopt;
  return MotionPrior{T_odom_predicted.Inverse(), covariance / PseudoHuberWeight(chi2, kPriorDelta)};
}

bool InertialMotionModel::CanCarry() const {
  if (!motion_ || !IsTrusted()) return false;
  const InertialFilter next = Propagated(filter_);
  const Matrix6d covariance = CameraCovariance(next);
  return LargestSigma(covariance, 0) < kFarthest_m && LargestSigma(covariance, 3) < kFarthest_rad;
}

std::optional<UpDirection> InertialMotionModel::Up() const {
  if (!IsHealthy() || (reach_.is_behind && !was_observed_)) return std::nullopt;
  InertialFilter filter = filter_;
  // Gravity in odom, seen from the last frame.
  if (reach_.is_behind) filter.ContinueAt(T_odom_observed_, covariance_observed_, 0.0);
  const auto up = filter.Up();
  if (!up) return std::nullopt;
  return UpDirection{imu_->T_imu_c.R().transpose() * up->direction, Hypot(up->sigma_rad, kMounting_rad)};
}

void InertialMotionModel::Begin(const SE3& T_odom_imu, const Matrix6d& covariance) {
  filter_.Begin(T_odom_imu, covariance, mean_force_m_s2_, knows_bias_);
  measured_s_ = reach_.known_s = unmeasured_s_ = standing_s_ = 0.0;
  n_contradicting_ = 0;
  reach_.is_behind = reach_.misses_samples = false;
}

/// Motions up to this time (clock of the sensor) are lost. A filter that knows little yet begins again.
void InertialMotionModel::ContinueAt(const SE3& T_odom_imu, const Matrix6d& covariance, int64_t t_ns) {
  if (measured_s_ < kFirstUse_s) return Begin(T_odom_imu, covariance);
  const uint64_t unknown_ns =
      t_ns > reach_.t_ns ? static_cast<uint64_t>(t_ns) - static_cast<uint64_t>(reach_.t_ns) : 0;
  filter_.ContinueAt(T_odom_imu, covariance, 1e-9 * static_cast<double>(unknown_ns));
  reach_.known_s = unmeasured_s_ = standing_s_ = 0.0;
  n_contradicting_ = 0;
  reach_.is_behind = reach_.misses_samples = false;
  reach_.t_ns = t_ns;
}

void InertialMotionModel::Observe(const SE3& T_odom_c, const Matrix6d& covariance, bool is_sure, bool jumped) {
  if (!imu_ || is_not_later_) return;
  if (!is_sure) return Miss();
  const SE3 T_odom_imu = T_odom_c * imu_->T_imu_c.Inverse();
  const SE3 T_odom_previous = std::exchange(T_odom_observed_, T_odom_imu);
  const bool follows = std::exchange(was_observed_, true);
  covariance_observed_ = MeasuredCovariance(covariance);
  if (!motion_) {
    // The samples of the motion are missing, or this is the first frame; the mean force is that of an earlier motion.
    if (!filter_.has_begun()) return;
    return jumped ? Begin(T_odom_imu, covariance_observed_) : FallBehind();
  }
  if (reach_.is_behind) return ContinueAt(T_odom_imu, covariance_observed_, interval_.to_ns);
  if (!filter_.has_begun()) {
    if (!follows) return Begin(T_odom_imu, covariance_observed_);
    Begin(T_odom_previous, covariance_observed_);
  }
  if (follows && !jumped) {
    AddEvidence(T_odom_previous.Inverse() * T_odom_imu);
    LearnStanding(T_odom_previous.Inverse() * T_odom_imu);
  }
  Take(T_odom_imu, covariance_observed_, jumped);
}

/// Moves the filter to a measured pose of the sensor, and takes it unless it contradicts the motion.
void InertialMotionModel::Take(const SE3& T_odom_imu, const Matrix6d& covariance, bool jumped) {
  unmeasured_s_ += motion_->dt_s();
  const double innovation = Propagated(filter_).AgreementWith(T_odom_imu, covariance).innovation;
  if (innovation > kGate) {
    filter_.Propagate(*motion_);
    // A jump is not a fault of the sensor.
    if (jumped) return Begin(T_odom_imu, covariance);
    if (++n_contradicting_ >= kMostContradicting) Begin(T_odom_imu, covariance);
    return AddInnovation(kGate / 6.0);
  }
  n_contradicting_ = 0;
  if (!jumped) AddInnovation(innovation / 6.0);
  Measure(T_odom_imu, covariance);
  measured_s_ += motion_->dt_s();
  reach_.known_s += motion_->dt_s();
  knows_bias_ = knows_bias_ || measured_s_ >= kFirstUse_s;
  unmeasured_s_ = 0.0;
}

void InertialMotionModel::AddInnovation(double normalised_innovation) {
  innovation_ += (normalised_innovation - innovation_) / kMeanFrames;
  agreeing_s_ = innovation_ < kAgreeing ? agreeing_s_ + motion_->dt_s() : 0.0;
  is_contradicting_ = innovation_ >= kHealthy || (is_contradicting_ && agreeing_s_ < kAgreeing_s);
}

void InertialMotionModel::Drift(const Matrix6d& motion_covariance) {
  if (!imu_ || is_not_later_ || !filter_.has_begun() || unmeasured_s_ > 0.0) return;
  const Eigen::Matrix3d R = imu_->T_imu_c.R();
  filter_.Drift(kMotionAlone * R * motion_covariance.bottomRightCorner<3, 3>() * R.transpose());
  filter_.MeasureFromHere();
}

/// Moves the filter over the motion and takes the pose of the sensor. Rotations are linear in the bias over a small angle
/// only: a motion that reveals a large error of the bias is integrated again with the better one (an iterated Kalman
/// filter).
void InertialMotionModel::Measure(const SE3& T_odom_imu, const Matrix6d& covariance) {
  const InertialFilter before = filter_;
  for (int pass = 0; pass < kMostPasses && motion_; ++pass) {
    filter_ = Propagated(before);
    filter_.Update(T_odom_imu, covariance);
    const ImuBias& bias = filter_.state().bias;
    if ((bias.rate_rad_s - motion_->bias().rate_rad_s).norm() * motion_->dt_s() < kLinear_rad) break;
    Integrate(bias);
  }
  filter_.MeasureFromHere();
}

void InertialMotionModel::LearnStanding(const SE3& T_previmu_imu) {
  const Vector6d motion = T_previmu_imu.Log();
  const bool stands = motion.head<3>().norm() < kStanding_m && motion.tail<3>().norm() < kStanding_rad;
  if (standing_s_ == 0.0) standing_force_m_s2_ = mean_force_m_s2_;
  standing_s_ = stands && IsQuiet() ? standing_s_ + motion_->dt_s() : 0.0;
  standing_force_m_s2_ += motion_->dt_s() / kFirstUse_s * (mean_force_m_s2_ - standing_force_m_s2_);
}

bool InertialMotionModel::IsQuiet() const {
  const ImuNoise& noise = imu_->calibration.noise;
  const double root_s = std::sqrt(motion_->dt_s());
  const Eigen::Vector3d rate_rad_s =
      SE3(motion_->RotationWith(filter_.state().bias), Eigen::Vector3d::Zero()).Log().tail<3>() / motion_->dt_s();
  return rate_rad_s.norm() < kQuietSigmas * noise.gyroscope_rad_s_sqrt_hz / root_s + kStandingRate_rad_s &&
         (mean_force_m_s2_ - standing_force_m_s2_).norm() < kQuietSigmas * noise.accelerometer_m_s2_sqrt_hz / root_s;
}

void InertialMotionModel::AddEvidence(const SE3& T_previmu_imu) {
  const double seen_rad = T_previmu_imu.Log().tail<3>().norm();
  if (knows_bias_) {
    const SE3 sensed(motion_->RotationWith(filter_.state().bias), Eigen::Vector3d::Zero());
    evidence_.compared_turn_rad += seen_rad;
    evidence_.turn_difference_rad += (sensed.Inverse() * T_previmu_imu).Log().tail<3>().norm();
  }
  evidence_.force_m_s += mean_force_m_s2_.norm() * motion_->dt_s();
  evidence_.time_s += motion_->dt_s();
}

std::string InertialMotionModel::Complaint() const {
  if (!imu_ || evidence_.time_s < kLeastEvidence_s) return {};
  if (!is_contradicting_) return {};
  const std::string sentence = fmt::format(
      "the inertial sensor contradicts the images, so it is not used: its normalised innovation is {:.1f} (1 is "
      "healthy)",
      innovation_);
  if (evidence_.compared_turn_rad > kLeastTurn_rad &&
      evidence_.turn_difference_rad < kSameTurn * evidence_.compared_turn_rad) {
    return sentence + fmt::format(
                          "; its rotations agree with those of the images to {:.1f} %, so its mounting and "
                          "units are right: are its noise densities too small, or time_offset_s wrong?",
                          100.0 * evidence_.turn_difference_rad / evidence_.compared_turn_rad);
  }
  return sentence + "; are T_b_imu, T_b_cam, time_offset_s and the noise densities right?";
}

void InertialMotionModel::Miss() {
  if (is_not_later_) return;
  was_observed_ = false;
  if (!imu_ || !filter_.has_begun()) return;
  if (!motion_ || reach_.is_behind) return FallBehind();
  filter_.Propagate(*motion_);
  unmeasured_s_ += motion_->dt_s();
  if (!IsQuiet()) standing_s_ = 0.0;
  if (standing_s_ >= kStandingSeen_s) filter_.StandStill(kStanding_m_s);
}

}  // namespace plslam::vo
