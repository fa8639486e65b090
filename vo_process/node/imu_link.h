// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/bus/messages/imu_channel.h"
#include "core/geometry/imu.h"
#include "core/ids/ids.h"
#include "core/process/partner_wait.h"
#include "core/process/process.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// A tracker's link to the inertial sensor (channel IMU). In lockstep a frame waits until all samples since the
/// previous frame have arrived, or none have been received for `bus.partner_wait_s`; a live frame waits for
/// `live_wait_ms` after its arrival, and is then tracked with the samples received.
class ImuLink {
 public:
  /// `on_arrival` is called when samples have arrived, or a wait may be over.
  ImuLink(bus::Process& process, const ImuUseOptions& options, std::function<void()> on_arrival);

  /// Whether the frame at this time of the stream of `source`, which arrived at `came_s` of the steady clock, has to
  /// wait for the samples since `prev_t_ns`.
  bool Awaits(SourceId source, int64_t prev_t_ns, int64_t t_ns, bool lockstep, double came_s);
  /// Returns the samples received since `from_ns`, in order of increasing time, for a frame whose wait is over, and drops
  /// those before: later frames do not need them. `offset_ns` is the time offset of the sensor.
  std::vector<ImuSample> Take(int64_t from_ns, int64_t t_ns, int64_t offset_ns);

 private:
  void OnBatch(SourceId source, const bus::ImuBatch& batch);
  bool Covers(SourceId source, int64_t prev_t_ns, int64_t t_ns) const;

  bus::Process& process_;
  ImuUseOptions options_;
  std::function<void()> on_arrival_;
  bus::PartnerWait wait_;
  int64_t awaited_t_ns_ = 0;
  /// Publisher of the samples, and the interval of frames of which all have arrived.
  SourceId source_;
  int64_t from_ns_ = 0;
  int64_t to_ns_ = 0;
  std::map<int64_t, ImuSample> samples_;  ///< by their times
};

}  // namespace plslam::vo
