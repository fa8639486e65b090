// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/sensor_diagnosis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/inertial/inertial_filter.h"

namespace plslam {
namespace {

// Number of measured motions between two diagnoses, and before the first one.
constexpr int kEvery = 5;
constexpr double kFirst_s = 1.0;
// Errors of seen turns that their covariance lacks (landmarks, stamps, scale of the gyroscope), each axis.
constexpr double kCommon_rad = 0.02 * kRadPerDeg;
// Motion between two frames of a camera that does not stand.
constexpr double kMoves_m = 0.003;
constexpr double kMoves_rad = 0.05 * kRadPerDeg;

// Penalties of `TurnAlignment`: inverse extrinsics are the most frequent mistake, and a mounting can only be a rotation;
// reflections come from drivers.
constexpr double kInversePenalty = 60.0;
constexpr double kRotatedPenalty = 64.0;
constexpr double kReflectedPenalty = 66.0;
// Evidence that is enough for a finding.
constexpr double kSureEvidence = 5.0;
// Rms of seen turns over their sigma, below which the camera stands, and shows nothing.
constexpr double kLeastExcitation = 2.0;
// Turn of the mounting, scale and delay up to which a sensor is useful as it is.
constexpr double kMounted_rad = 8.0 * kRadPerDeg;
constexpr double kScale = 1.3;
constexpr double kDelay_s = 0.008;
constexpr double kDelaySigmas = 4.0;

// Bounds on the mean specific force of a sensor that measures in m/s^2.
constexpr double kLeastForce_m_s2 = 7.0;
constexpr double kMostForce_m_s2 = 14.0;
// Ratio of noise densities above which the stated ones are wrong: vibration is several times the white noise of a data
// sheet, and the noise of turns must be higher, too.
constexpr double kNoiseRatio = 20.0;
constexpr double kTurnNoiseRatio = 8.0;
constexpr double kRateRatio = 1.5;
// Time for which a harmful fault has to be absent to end.
constexpr double kAbsent_s = 5.0;
// Share of saturated samples above which the motions in between are doubtful, too. Their frames are left out anyhow.
constexpr double kSaturatedShare = 0.02;
// Degrees in a radian.
constexpr double kDegrees = 1.0 / kRadPerDeg;

/// Matrices with one element of 1 or -1 in each row and column, the identity first.
std::vector<Eigen::Matrix3d> SignedPermutations() {
  std::vector<Eigen::Matrix3d> matrices;
  for (const auto& order : {std::array<int, 3>{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) matrix(row, order[row]) = (signs >> row & 1) != 0 ? -1.0 : 1.0;
      matrices.push_back(matrix);
    }
  }
  return matrices;
}

double AngleOf(const Eigen::Matrix3d& R) { return SE3(R, Eigen::Vector3d::Zero()).Log().tail<3>().norm(); }

std::string Rows(const Eigen::Matrix3d& R) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double value = std::abs(R(row, column)) < 5e-4 ? 0.0 : R(row, column);
      text += fmt::format("{}{:.3g}", text.empty() ? "" : column == 0 ? "; " : ", ", value);
    }
  }
  return text;
}

}  // namespace

SensorDiagnosis::SensorDiagnosis(const ImuCalibration& stated, const SE3& T_imu_c)
    : stated_(stated), T_imu_c_(T_imu_c) {
  axes_.push_back({});
  const Eigen::Matrix3d R_b_imu = stated.T_b_imu.R(), R_c_imu = T_imu_c.Inverse().R();
  for (const Eigen::Matrix3d& R : {R_b_imu, R_c_imu}) {
    const Eigen::Matrix3d twice = R * R;
    const bool is_new = std::none_of(axes_.begin(), axes_.end(), [&](const AxisHypothesis& other) {
      return AngleOf(twice * other.matrix.transpose()) < kMounted_rad;
    });
    if (is_new) axes_.push_back({twice, kInversePenalty});
  }
  n_inverse_ = axes_.size() - 1;
  for (const Eigen::Matrix3d& matrix : SignedPermutations()) {
    const bool is_new = std::none_of(axes_.begin(), axes_.end(), [&](const AxisHypothesis& other) {
      return (matrix - other.matrix).norm() < kMounted_rad;
    });
    if (!is_new) continue;
    axes_.push_back({matrix, matrix.determinant() > 0.0 ? kRotatedPenalty : kReflectedPenalty});
  }
}

bool SensorDiagnosis::Add(std::span<const ImuSample> samples, int64_t frame_ns) {
  const int n_before = samples_.n_saturated();
  for (const ImuSample& sample : samples) {
    if (!has_samples_ || sample.t_ns > newest_ns_) {
      samples_.Add(sample);
      turns_.Add(sample);
      newest_ns_ = sample.t_ns;
      has_samples_ = true;
    }
    if (sample.t_ns >= frame_ns) break;
  }
  const bool is_saturated = n_before > 0 && samples_.n_saturated() > n_before;
  return !is_saturated && !(moves_ && IsStuck());
}

bool SensorDiagnosis::IsStuck() const { return std::max(samples_.RatesStuck_s(), samples_.ForcesStuck_s()) > 0.0; }

void SensorDiagnosis::Add(int64_t from_ns, int64_t to_ns, const SE3& T_prev_c, const Matrix6d& covariance) {
  if (to_ns <= from_ns) return;
  const Vector6d motion = T_prev_c.Log();
  moves_ = motion.head<3>().norm() > kMoves_m || motion.tail<3>().norm() > kMoves_rad;
  const double dt_s = 1e-9 * static_cast<double>(static_cast<uint64_t>(to_ns) - static_cast<uint64_t>(from_ns));
  const double variance_rad2 = covariance.diagonal().tail<3>().mean() + kCommon_rad * kCommon_rad;
  // Samples that repeat show neither units nor axes.
  if (samples_.RatesStuck_s() == 0.0) {
    turns_.Add({from_ns, to_ns, T_imu_c_.rotation() * motion.tail<3>(), variance_rad2});
  }
  time_s_ += dt_s;
  same_s_ += dt_s;
  if (++n_pairs_ % kEvery == 0) Diagnose();
}

bool SensorDiagnosis::IsHarmful() const {
  return std::any_of(findings_.begin(), findings_.end(), [](const SensorFinding& f) { return f.is_harmful; });
}

void SensorDiagnosis::Report(SensorFinding::Fault fault, bool is_harmful, std::string text) {
  findings_.push_back({fault, is_harmful, std::move(text)});
}

void SensorDiagnosis::Diagnose() {
  if (time_s_ < kFirst_s) return;
  const std::vector<SensorFinding> before = std::exchange(findings_, {});
  fit_ = turns_.Fit(axes_, std::max(stated_.noise.gyroscope_rad_s_sqrt_hz, samples_.RateNoise()));
  CheckForces();
  CheckTurns();
  CheckSamples();
  HoldHarmful(time_s_ - std::exchange(diagnosed_s_, time_s_));
  const auto same = [](const SensorFinding& a, const SensorFinding& b) { return a.fault == b.fault; };
  if (!std::equal(before.begin(), before.end(), findings_.begin(), findings_.end(), same)) same_s_ = 0.0;
}

bool SensorDiagnosis::IsHeld(SensorFinding::Fault fault) const {
  return std::any_of(held_.begin(), held_.end(), [&](const Held& held) { return held.finding.fault == fault; });
}

/// Adds the harmful faults that were found before and have not been absent for long. Turns that are too small show
/// nothing of theirs.
void SensorDiagnosis::HoldHarmful(double dt_s) {
  using Fault = SensorFinding::Fault;
  for (const SensorFinding& finding : findings_) {
    if (!finding.is_harmful) continue;
    std::erase_if(held_, [&](const Held& held) { return held.finding.fault == finding.fault; });
    held_.push_back({finding, -dt_s});
  }
  const auto is_of_turns = [](const Held& held) {
    const Fault fault = held.finding.fault;
    return fault == Fault::kRateUnit || fault == Fault::kAxes || fault == Fault::kTimeOffset;
  };
  // Noise explains turns that do not agree better than what they showed before.
  if (IsHeld(Fault::kNoise)) std::erase_if(held_, is_of_turns);
  for (Held& held : held_) {
    if (!is_of_turns(held) || fit_.excitation >= kLeastExcitation) held.absent_s += dt_s;
  }
  std::erase_if(held_, [](const Held& held) { return held.absent_s >= kAbsent_s; });
  for (const Held& held : held_) {
    const auto is_same = [&](const SensorFinding& f) { return f.fault == held.finding.fault; };
    const auto found = std::find_if(findings_.begin(), findings_.end(), is_same);
    if (found != findings_.end() && found->is_harmful) continue;
    std::erase_if(findings_, is_same);
    findings_.push_back(held.finding);
  }
  std::stable_sort(findings_.begin(), findings_.end(),
                   [](const SensorFinding& a, const SensorFinding& b) { return a.fault < b.fault; });
}

void SensorDiagnosis::CheckForces() {
  const double force_m_s2 = samples_.Force_m_s2();
  const bool is_known = force_m_s2 > 0.0;
  const double below_m_s2 = Bound(SensorFinding::Fault::kForceUnit, kGravity_m_s2 - kLeastForce_m_s2);
  const double above_m_s2 = Bound(SensorFinding::Fault::kForceUnit, kMostForce_m_s2 - kGravity_m_s2);
  const bool is_gravity = force_m_s2 > kGravity_m_s2 - below_m_s2 && force_m_s2 < kGravity_m_s2 + above_m_s2;
  if (!is_known || is_gravity) return;
  const bool in_g = force_m_s2 > kLeastForce_m_s2 / kGravity_m_s2 && force_m_s2 < kMostForce_m_s2 / kGravity_m_s2;
  Report(SensorFinding::Fault::kForceUnit, true,
         fmt::format("its mean specific force is {:.2f} m/s^2 instead of 9.8{}", force_m_s2,
                     in_g ? ": g instead of m/s^2?" : ": another unit, or gravity removed?"));
}

void SensorDiagnosis::CheckTurns() {
  if (fit_.evidence < kSureEvidence || fit_.excitation < kLeastExcitation) return;
  // The rates of a saturated gyroscope are too small.
  const bool is_saturated = fit_.scale < 1.0 && samples_.MostSaturated().n_samples > 0;
  const double scale = 1.0 + Bound(SensorFinding::Fault::kRateUnit, kScale - 1.0);
  if (!is_saturated && (fit_.scale > scale || fit_.scale < 1.0 / scale)) {
    const bool in_degrees = std::abs(fit_.scale / kDegrees - 1.0) < 0.2;
    Report(SensorFinding::Fault::kRateUnit, true,
           fmt::format("the gyroscope turns {:.3g} times as fast as the images: {}", fit_.scale,
                       in_degrees ? "degrees instead of rad/s?" : "another unit?"));
  }
  const bool is_turned =
      fit_.matrix.determinant() < 0.0 || AngleOf(fit_.matrix) > Bound(SensorFinding::Fault::kAxes, kMounted_rad);
  if (is_turned) Report(SensorFinding::Fault::kAxes, true, AxesText());
  // A constant rate shows no delay.
  if (fit_.variation > kLeastExcitation &&
      std::abs(fit_.delay_s) >
          Bound(SensorFinding::Fault::kTimeOffset, std::max(kDelay_s, kDelaySigmas * fit_.delay_sigma_s))) {
    Report(SensorFinding::Fault::kTimeOffset, true,
           fmt::format("its stamps are {:.1f} +- {:.1f} ms {}: time_offset_s: {:.4f}?", 1e3 * std::abs(fit_.delay_s),
                       1e3 * fit_.delay_sigma_s, fit_.delay_s > 0.0 ? "late" : "early",
                       stated_.time_offset_s - fit_.delay_s));
  }
}

std::string SensorDiagnosis::AxesText() const {
  const Eigen::Matrix3d R_b_imu = stated_.T_b_imu.R() * fit_.matrix.transpose();
  if (fit_.n_rivals > 0) {
    return fmt::format(
        "its turns contradict those of the images, about other axes: is the rotation of T_b_imu right?");
  }
  if (fit_.axes >= 1 && fit_.axes <= n_inverse_) {
    return fmt::format(
        "its turns fit the images with the inverse of the stated pose: is T_b_imu the wrong way round? "
        "Its rotation would be [{}]",
        Rows(R_b_imu));
  }
  if (fit_.axes >= axes_.size()) {
    return fmt::format(
        "it is turned by {:.0f} degrees from the stated mounting: the rotation of T_b_imu would be [{}]",
        AngleOf(fit_.matrix) / kRadPerDeg, Rows(R_b_imu));
  }
  std::string names;
  for (int row = 0; row < 3; ++row) {
    int column = 0;
    fit_.matrix.row(row).cwiseAbs().maxCoeff(&column);
    names += fmt::format("{}{}{}", row == 0 ? "" : ", ", fit_.matrix(row, column) < 0.0 ? "-" : "", "xyz"[column]);
  }
  if (fit_.matrix.determinant() < 0.0) {
    return fmt::format(
        "it turns about ({}) where the images turn about (x, y, z): axes exchanged or inverted by the "
        "driver?",
        names);
  }
  return fmt::format(
      "it turns about ({}) where the images turn about (x, y, z): the rotation of T_b_imu would be [{}]", names,
      Rows(R_b_imu));
}

void SensorDiagnosis::CheckSamples() {
  const double rates_s = samples_.RatesStuck_s(), forces_s = samples_.ForcesStuck_s();
  const bool is_stuck = moves_ && std::max(rates_s, forces_s) > 0.0;
  if (is_stuck) {
    Report(SensorFinding::Fault::kStuck, true,
           fmt::format("its {} have been the same for {:.1f} s while the images move: it is stuck",
                       rates_s > 0.0 && forces_s > 0.0 ? "samples"
                       : rates_s > 0.0                 ? "rates"
                                                       : "forces",
                       std::max(rates_s, forces_s)));
  }
  const ImuNoise& noise = stated_.noise;
  const double stated = std::max(noise.gyroscope_rad_s_sqrt_hz, 1e-9);
  const double rates = samples_.RateNoise() / stated, turns = fit_.residual_rad_sqrt_s / stated;
  if (findings_.empty() && rates > Bound(SensorFinding::Fault::kNoise, kNoiseRatio) &&
      turns > Bound(SensorFinding::Fault::kNoise, kTurnNoiseRatio)) {
    Report(SensorFinding::Fault::kNoise, true,
           fmt::format("the noise of its rates is {:.0f} times the stated one: gyroscope_noise_density: {:.2g} and "
                       "accelerometer_noise_density: {:.2g}?",
                       rates, samples_.RateNoise(), samples_.ForceNoise()));
  }
  const SampleChecks::Saturation saturation = samples_.MostSaturated();
  if (!is_stuck && saturation.n_samples > 0) {
    Report(SensorFinding::Fault::kSaturation,
           saturation.share > Bound(SensorFinding::Fault::kSaturation, kSaturatedShare),
           fmt::format("{} samples end at {:.3g} {} about {}: the range of the {} is too small", saturation.n_samples,
                       saturation.bound, saturation.of_rate ? "rad/s" : "m/s^2", "xyz"[saturation.axis],
                       saturation.of_rate ? "gyroscope" : "accelerometer"));
  }
  if (samples_.n_gaps() > 0) {
    Report(SensorFinding::Fault::kGaps, false,
           fmt::format("its samples have {} gap{}, the longest of {:.2f} s", samples_.n_gaps(),
                       samples_.n_gaps() == 1 ? "" : "s", samples_.longest_gap_s()));
  }
  const double rate_hz = samples_.Rate_hz();
  const bool is_other = rate_hz > kRateRatio * stated_.rate_hz || kRateRatio * rate_hz < stated_.rate_hz;
  if (stated_.rate_hz > 0.0 && rate_hz > 0.0 && is_other) {
    Report(SensorFinding::Fault::kRate, false,
           fmt::format("it delivers {:.0f} samples a second instead of the stated {:.0f}: rate_hz: {:.0f}?", rate_hz,
                       stated_.rate_hz, rate_hz));
  }
}

}  // namespace plslam
