// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "core/bus/channels.h"
#include "core/geometry/stereo_camera.h"
#include "plslam/pose_t.hpp"

int main() {
  const plslam::StereoCamera camera{400.0, 320.0, 240.0, 0.1, 640, 480};
  const plslam::pose_t message{};
  std::printf("%zu channels, %d bytes, %.1f m\n", plslam::bus::Channels().size(),
              message.getEncodedSize() > 0 ? 1 : 0, camera.Depth(10.0));
}
