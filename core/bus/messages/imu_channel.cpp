// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/imu_channel.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/bus/messages/convert.h"
#include "plslam/imu_interval_t.hpp"
#include "plslam/imu_sample_t.hpp"
#include "plslam/imu_t.hpp"
#include "plslam/pose3_t.hpp"

namespace plslam::bus {
namespace {

// Size of an encoded imu_sample_t.
constexpr int64_t kSampleBytes = 7 * 8;
constexpr size_t kNumbers = 13;

void SetAxes(const Eigen::Vector3d& from, double (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

Eigen::Vector3d AxesOf(const double (&from)[3]) { return Eigen::Map<const Eigen::Vector3d>(&from[0]); }

}  // namespace

imu_sample_t ToMessage(const ImuSample& sample) {
  imu_sample_t message{};
  message.t_ns = sample.t_ns;
  SetAxes(sample.rate_rad_s, message.rate_rad_s);
  SetAxes(sample.force_m_s2, message.force_m_s2);
  return message;
}

bool AppendTo(std::vector<ImuSample>& samples, const imu_sample_t& message) {
  const ImuSample next{message.t_ns, AxesOf(message.rate_rad_s), AxesOf(message.force_m_s2)};
  const bool is_later = samples.empty() || next.t_ns > samples.back().t_ns;
  if (!is_later || !next.rate_rad_s.allFinite() || !next.force_m_s2.allFinite()) return false;
  samples.push_back(next);
  return true;
}

imu_interval_t ToMessage(const InertialInterval& interval) {
  imu_interval_t message{};
  message.from_ns = interval.from_ns;
  message.to_ns = interval.to_ns;
  message.T_kf_imu = ToMessage(interval.T_c_imu);
  message.gyroscope_rad_s_sqrt_hz = interval.noise.gyroscope_rad_s_sqrt_hz;
  message.gyroscope_walk_rad_s2_sqrt_hz = interval.noise.gyroscope_walk_rad_s2_sqrt_hz;
  message.accelerometer_m_s2_sqrt_hz = interval.noise.accelerometer_m_s2_sqrt_hz;
  message.accelerometer_walk_m_s3_sqrt_hz = interval.noise.accelerometer_walk_m_s3_sqrt_hz;
  SetAxes(interval.bias.mean.rate_rad_s, message.rate_bias_rad_s);
  SetAxes(interval.bias.mean.force_m_s2, message.force_bias_m_s2);
  message.rate_bias_sigma_rad_s = interval.bias.rate_sigma_rad_s;
  message.force_bias_sigma_m_s2 = interval.bias.force_sigma_m_s2;
  return message;
}

std::optional<InertialInterval> FromMessage(const imu_interval_t& message) {
  InertialInterval interval;
  if (message.from_ns == message.to_ns) return interval;
  interval.from_ns = message.from_ns;
  interval.to_ns = message.to_ns;
  interval.noise = {message.gyroscope_rad_s_sqrt_hz, message.gyroscope_walk_rad_s2_sqrt_hz,
                    message.accelerometer_m_s2_sqrt_hz, message.accelerometer_walk_m_s3_sqrt_hz};
  interval.bias = {{AxesOf(message.rate_bias_rad_s), AxesOf(message.force_bias_m_s2)},
                   message.rate_bias_sigma_rad_s,
                   message.force_bias_sigma_m_s2};
  const auto T_kf_imu = FromMessage(message.T_kf_imu);
  const bool is_in_order =
      interval.from_ns < interval.to_ns && interval.LengthUntil(interval.to_ns) <= InertialInterval::kLongest_ns;
  const bool is_finite = interval.bias.mean.rate_rad_s.allFinite() && interval.bias.mean.force_m_s2.allFinite();
  const bool is_positive = PositiveFinite(
      {message.gyroscope_rad_s_sqrt_hz, message.gyroscope_walk_rad_s2_sqrt_hz, message.accelerometer_m_s2_sqrt_hz,
       message.accelerometer_walk_m_s3_sqrt_hz, message.rate_bias_sigma_rad_s, message.force_bias_sigma_m_s2});
  if (!T_kf_imu || !is_in_order || !is_finite || !is_positive) return std::nullopt;
  interval.T_c_imu = *T_kf_imu;
  return interval;
}

imu_t ToMessage(const ImuBatch& batch) {
  imu_t message{};
  message.header.t_ns = batch.t_ns;
  message.from_ns = batch.from_ns;
  message.complete = batch.complete ? 1 : 0;
  message.n_samples = static_cast<int32_t>(batch.samples.size());
  for (const ImuSample& sample : batch.samples) message.samples.push_back(ToMessage(sample));
  return message;
}

std::optional<ImuBatch> FromMessage(const imu_t& message) {
  ImuBatch batch{message.from_ns, message.header.t_ns, message.complete != 0, {}};
  batch.samples.reserve(message.samples.size());
  for (const imu_sample_t& sample : message.samples) {
    if (!AppendTo(batch.samples, sample)) return std::nullopt;
  }
  return batch;
}

void PublishImu(Bus& bus, int64_t from_ns, int64_t t_ns, std::span<const ImuSample> samples) {
  const int64_t room = bus.page_bytes() - imu_t{}.getEncodedSize();
  const auto most = static_cast<size_t>(std::max<int64_t>(1, room / kSampleBytes));
  do {
    const size_t n = std::min(most, samples.size());
    const ImuBatch batch{
        from_ns, t_ns, n == samples.size(), {samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(n)}};
    bus.Publish(kImu, ToMessage(batch));
    samples = samples.subspan(n);
  } while (!samples.empty());
}

std::string ImuText(const ImuCalibration& imu) {
  const pose3_t T = ToMessage(imu.T_b_imu);
  const std::array<double, kNumbers> numbers{T.position_m[0],
                                             T.position_m[1],
                                             T.position_m[2],
                                             T.q_wxyz[0],
                                             T.q_wxyz[1],
                                             T.q_wxyz[2],
                                             T.q_wxyz[3],
                                             imu.noise.gyroscope_rad_s_sqrt_hz,
                                             imu.noise.gyroscope_walk_rad_s2_sqrt_hz,
                                             imu.noise.accelerometer_m_s2_sqrt_hz,
                                             imu.noise.accelerometer_walk_m_s3_sqrt_hz,
                                             imu.time_offset_s,
                                             imu.rate_hz};
  std::string text;
  for (const double number : numbers) {
    std::array<char, 32> digits{};
    const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    text.append(text.empty() ? "" : " ").append(digits.data(), result.ptr);
  }
  return text;
}

std::optional<ImuCalibration> ImuFromText(std::string_view text) {
  std::array<double, kNumbers> numbers{};
  const char* at = text.data();
  const char* end = at + text.size();
  for (size_t i = 0; i < kNumbers; ++i) {
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    const bool is_last = i + 1 == kNumbers;
    if (error != std::errc() || !std::isfinite(numbers[i])) return std::nullopt;
    if (is_last ? next != end : next == end || *next != ' ') return std::nullopt;
    at = next + 1;
  }
  pose3_t pose{};
  std::copy_n(numbers.begin(), 3, &pose.position_m[0]);
  std::copy_n(numbers.begin() + 3, 4, &pose.q_wxyz[0]);
  const std::optional<SE3> T_b_imu = FromMessage(pose);
  const bool noise_ok = std::all_of(numbers.begin() + 7, numbers.begin() + 11, [](double v) { return v > 0.0; });
  if (!T_b_imu || !noise_ok || std::abs(numbers[11]) > kMaxImuOffset_s || numbers[12] < 0.0) return std::nullopt;
  return ImuCalibration{*T_b_imu, {numbers[7], numbers[8], numbers[9], numbers[10]}, numbers[11], numbers[12]};
}

}  // namespace plslam::bus
