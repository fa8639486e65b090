// SPDX-License-Identifier: BSD-3-Clause
// Prints the poses of a running system.
//
//   listen URL [FRAMES]      (URL: as printed by plslam run, or udpm://239.255.76.67:7667?ttl=0)
//
// Prints T_w_c (w: the map; c: the rectified left camera) as `t x y z qx qy qz qw`; ends after FRAMES poses.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "core/bus/bus.h"
#include "core/bus/messages/convert.h"
#include "core/run/tracking_state.h"
#include "plslam/pose_t.hpp"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: listen URL [FRAMES]\n", stderr);
    return 1;
  }
  try {
    long remaining = argc > 2 ? std::atol(argv[2]) : -1;
    plslam::bus::BusOptions options;
    options.url = argv[1];
    plslam::bus::Bus bus(options, "listen");
    bus.Subscribe<plslam::pose_t>(plslam::bus::kPose, [&](const plslam::pose_t& pose) {
      const auto T_w_odom = plslam::bus::FromMessage(pose.T_w_odom);
      const auto T_odom_c = plslam::bus::FromMessage(pose.T_odom_c);
      if (!T_w_odom || !T_odom_c) return;  // not finite
      if (!plslam::IsTracked(static_cast<plslam::TrackingState>(pose.state), pose.keyframe_id)) return;
      const plslam::SE3 T_w_c = *T_w_odom * *T_odom_c;
      const auto& t = T_w_c.translation();
      const auto& q = T_w_c.rotation();
      std::printf("%.9f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", 1e-9 * static_cast<double>(pose.header.t_ns), t.x(),
                  t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
      std::fflush(stdout);
      if (remaining > 0 && --remaining == 0) bus.Stop();
    });
    bus.Run();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "listen: error: %s\n", e.what());
    return 1;
  }
}
