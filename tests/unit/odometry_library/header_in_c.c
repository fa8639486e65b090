// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/odometry_library/header_in_c.h"

#include "tools/odometry_library/plslam_odometry.h"

/* Tracks one pair as a program in C does. */
int TrackOnePairInC(const char* calibration, const void* left, const void* right, int width_px, int height_px) {
  char error[200];
  plslam_odometry* odometry = plslam_odometry_create(calibration, 0, 0, NULL, error, sizeof error);
  const plslam_image left_image = {left, width_px, width_px, height_px, 8};
  const plslam_image right_image = {right, width_px, width_px, height_px, 8};
  plslam_pose pose;
  int tracked = 0;
  if (odometry == NULL) return 0;
  tracked = plslam_odometry_track(odometry, 1, &left_image, &right_image, &pose) == 0 && pose.is_keyframe;
  plslam_odometry_destroy(odometry);
  return tracked;
}
