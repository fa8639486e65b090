// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/imu_channel.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/bus/messages/convert.h"
#include "plslam/imu_sample_t.hpp"
#include "plslam/imu_t.hpp"
#include "plslam/pose3_t.hpp"

namespace plslam::bus {
namespace {

// Size of an encoded imu_sample_t.
constexpr int64_t kSampleBytes = 7 * 8;
constexpr size_t kNumbers = 13;

imu_sample_t ToSampleMessage(const ImuSample& sample) {
  imu_sample_t message{};
  message.t_ns = sample.t_ns;
  for (int i = 0; i < 3; ++i) message.rate_rad_s[i] = sample.rate_rad_s[i];
  for (int i = 0; i < 3; ++i) message.force_m_s2[i] = sample.force_m_s2[i];
  return message;
}

ImuSample FromSampleMessage(const imu_sample_t& message) {
  return {message.t_ns, Eigen::Map<const Eigen::Vector3d>(&message.rate_rad_s[0]),
          Eigen::Map<const Eigen::Vector3d>(&message.force_m_s2[0])};
}

}  // namespace

imu_t ToMessage(const ImuBatch& batch) {
  imu_t message{};
  message.header.t_ns = batch.t_ns;
  message.from_ns = batch.from_ns;
  message.complete = batch.complete ? 1 : 0;
  message.n_samples = static_cast<int32_t>(batch.samples.size());
  for (const ImuSample& sample : batch.samples) message.samples.push_back(ToSampleMessage(sample));
  return message;
}

std::optional<ImuBatch> FromMessage(const imu_t& message) {
  ImuBatch batch{message.from_ns, message.header.t_ns, message.complete != 0, {}};
  batch.samples.reserve(message.samples.size());
  for (const imu_sample_t& sample : message.samples) {
    const ImuSample next = FromSampleMessage(sample);
    const bool is_later = batch.samples.empty() || next.t_ns > batch.samples.back().t_ns;
    if (!is_later || !next.rate_rad_s.allFinite() || !next.force_m_s2.allFinite()) return std::nullopt;
    batch.samples.push_back(next);
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
