// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/imu_link.h"

#include <chrono>
#include <utility>

#include "core/bus/run_loop.h"
#include "plslam/imu_t.hpp"

namespace plslam::vo {
namespace {

// Number of samples kept: a minute of a fast sensor, more than frames ever wait.
constexpr size_t kMostSamples = 65536;
// Period of checks of waits.
constexpr std::chrono::milliseconds kImuTick(5);
constexpr const char* kNoSamples =
    "the rig has an inertial sensor, but its samples do not arrive (channel IMU), so frames are tracked without "
    "them: does the program that publishes the frames publish them, too?";

}  // namespace

ImuLink::ImuLink(bus::Process& process, const ImuUseOptions& options, std::function<void()> on_arrival)
    : process_(process),
      options_(options),
      on_arrival_(std::move(on_arrival)),
      wait_(process.bus().options().partner_wait_s) {
  process.bus().Subscribe<imu_t>(bus::kImu, [this, &process](const imu_t& message) {
    const auto batch = bus::FromMessage(message);
    if (!batch) return process.bus().CountRejected();
    wait_.OnSignOfLife(bus::NowS());
    OnBatch(SourceId(message.header.source), *batch);
    on_arrival_();
  });
  process.bus().Every(kImuTick, [this] {
    if (wait_.GiveUp(bus::NowS())) process_.Warn("imu_missing", kNoSamples);
    on_arrival_();
  });
}

/// Batches of another publisher are of another stream, or continue one whose publisher was killed with all samples
/// since the last frame that has a pose.
void ImuLink::OnBatch(SourceId source, const bus::ImuBatch& batch) {
  if (std::exchange(source_, source) != source) {
    samples_.clear();
    from_ns_ = to_ns_ = batch.from_ns;
  }
  for (const ImuSample& sample : batch.samples) samples_.emplace(sample.t_ns, sample);
  while (samples_.size() > kMostSamples) samples_.erase(samples_.begin());
  if (!batch.complete) return;
  // Frames that are sent again, after a tracker was restarted, begin another interval.
  const bool continues = batch.from_ns >= from_ns_ && batch.from_ns <= to_ns_;
  if (!continues) from_ns_ = batch.from_ns;
  if (!continues || batch.t_ns > to_ns_) to_ns_ = batch.t_ns;
}

bool ImuLink::Covers(SourceId source, int64_t prev_t_ns, int64_t t_ns) const {
  return source == source_ && from_ns_ <= prev_t_ns && to_ns_ >= t_ns;
}

bool ImuLink::Awaits(SourceId source, int64_t prev_t_ns, int64_t t_ns, bool lockstep, double came_s) {
  if (Covers(source, prev_t_ns, t_ns)) return false;
  const double now_s = bus::NowS();
  if (!lockstep) return now_s - came_s < 1e-3 * options_.live_wait_ms;
  if (std::exchange(awaited_t_ns_, t_ns) != t_ns) wait_.Begin(t_ns, now_s);
  return wait_.awaited().has_value();
}

std::vector<ImuSample> ImuLink::Take(int64_t from_ns, int64_t t_ns, int64_t offset_ns) {
  wait_.End();
  const auto after = [&](int64_t frame_ns) { return samples_.upper_bound(frame_ns - offset_ns); };
  auto begin = after(from_ns);
  if (begin != samples_.begin()) --begin;
  samples_.erase(samples_.begin(), begin);
  auto end = samples_.lower_bound(t_ns - offset_ns);
  if (end != samples_.end()) ++end;
  std::vector<ImuSample> taken;
  for (auto it = samples_.begin(); it != end; ++it) taken.push_back(it->second);
  return taken;
}

}  // namespace plslam::vo
