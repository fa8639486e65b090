// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/message_values.h"

#include "core/process/process_status.h"

namespace plslam::viewer {

OverlayFeatures ToOverlayFeatures(const tracks_t& message) {
  OverlayFeatures features;
  for (const track_point_t& p : message.points)
    features.points.push_back({{p.u_px, p.v_px}, p.disparity_px, p.age, p.body >= 0});
  for (const track_line_t& l : message.lines) {
    features.segments.push_back(
        {{l.p_px[0], l.p_px[1]}, {l.q_px[0], l.q_px[1]}, l.disparity_p_px, l.disparity_q_px, l.age, l.body >= 0});
  }
  return features;
}

ProcessSample ToProcessSample(const status_t& message, double t_s, FrameId frame_id) {
  ProcessSample sample{.process = message.process,
                       .state = message.state,
                       .t_s = t_s,
                       .frame_id = frame_id,
                       .cpu_s = message.cpu_s,
                       .memory_mb = message.memory_mb,
                       .counters = {},
                       .pid = message.pid};
  sample.queue = bus::LongestQueueOf(message);
  sample.uptime_s = message.uptime_s;
  for (const counter_t& counter : message.counters) sample.counters.emplace_back(counter.name, counter.value);
  return sample;
}

}  // namespace plslam::viewer
