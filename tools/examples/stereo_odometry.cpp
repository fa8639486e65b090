// SPDX-License-Identifier: BSD-3-Clause
// Stereo odometry without the bus: pairs in, poses out.
//
//   stereo_odometry DATASET      (a folder, a recording, or synthetic:room?frames=30)
//
// Prints T_odom_c (odom: the first camera; c: the rectified left camera) as `t x y z qx qy qz qw`.
#include <cstdio>
#include <exception>

#include "core/datasets/open_dataset.h"
#include "vo_process/tracking/odometry.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: stereo_odometry DATASET\n", stderr);
    return 1;
  }
  try {
    const auto dataset = plslam::OpenDataset(argv[1], "");
    const plslam::vo::VoOptions options;
    // A rig of your own is filled into a plslam::RigCalibration.
    plslam::vo::StereoFrontEnd front_end(dataset->rig(), options);
    plslam::vo::Odometry odometry(front_end.camera(), options, front_end.shutter());
    for (int i = 0; i < dataset->size(); ++i) {
      const plslam::StereoImages images = dataset->Read(i);  // grey cv::Mat `left` and `right`, and their time
      plslam::vo::StageTimer timer;
      const plslam::vo::OdometryResult result =
          odometry.Track(images.t_ns, odometry.SeePair(front_end, images, timer));
      if (!plslam::IsTracked(result.state, result.keyframe ? result.keyframe->id : -1)) continue;
      const auto& t = result.T_odom_c.translation();
      const auto& q = result.T_odom_c.rotation();
      std::printf("%.9f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", 1e-9 * static_cast<double>(images.t_ns), t.x(), t.y(),
                  t.z(), q.x(), q.y(), q.z(), q.w());
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "stereo_odometry: error: %s\n", e.what());
    return 1;
  }
}
