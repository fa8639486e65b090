// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/* Stereo odometry for C, and for all languages that call C: pairs of images in, poses out; no bus, no other process.
 *
 *   char error[512];
 *   plslam_odometry* odometry = plslam_odometry_create("camera.yaml", 0, 0, NULL, error, sizeof error);
 *   plslam_pose pose;
 *   while (next_pair(&left, &right, &t_ns)) {
 *     if (plslam_odometry_track(odometry, t_ns, &left, &right, &pose) != 0) puts(plslam_odometry_error(odometry));
 *   }
 *   plslam_odometry_destroy(odometry);
 *
 * The same pairs give the same bits as vo_process without a map. An odometry is used by one thread at a time; several
 * are independent. No function ends the program or throws. */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct plslam_odometry plslam_odometry;

/* An image as the camera records it (not rectified), rows from top to bottom; it is copied. */
typedef struct plslam_image {
  const void* pixels;
  int64_t row_bytes; /* from the beginning of a row to the next */
  int32_t width_px;
  int32_t height_px;
  int32_t bits; /* 8: grey; 16: depths, as the right image of an RGB-D camera */
} plslam_image;

/* Values of `plslam_pose.state`. Poses of lost frames are predictions. */
enum { PLSLAM_INITIALISING = 0, PLSLAM_TRACKING = 1, PLSLAM_WEAK = 2, PLSLAM_LOST = 3, PLSLAM_RECOVERED = 4 };

/* Matrices are row by row. T_a_b takes points of b to a, in metres; odom is the first camera, c the rectified left
 * camera (x right, y down, z forward), prev that of the previous frame. Covariances are of the right perturbation:
 * translation in m, then rotation in rad. */
typedef struct plslam_pose {
  int64_t t_ns;
  int32_t state;
  int32_t is_keyframe;
  int32_t tracked_points;
  int32_t tracked_lines;
  double T_odom_c[16];
  double covariance[36];
  double T_prev_c[16];
  double motion_covariance[36];
} plslam_pose;

/* Returns the version of the library, "0.3.0". */
const char* plslam_odometry_version(void);

/* `calibration`: camera.yaml, or a calibration file of another program (docs/datasets.md); `width_px` and `height_px`
 * are those of its images if the file does not state them, else 0. `options`: the section `vo` of a configuration, as
 * text ("vo: {tracking: {min_inliers: 20}}"); NULL: defaults. Returns NULL after an error, with one sentence in `error`
 * (of `error_bytes`, cut if it is longer; may be NULL). */
plslam_odometry* plslam_odometry_create(const char* calibration, int32_t width_px, int32_t height_px,
                                        const char* options, char* error, size_t error_bytes);

/* NULL is allowed. */
void plslam_odometry_destroy(plslam_odometry* odometry);

/* Tracks the next pair; `t_ns` is the time of its exposure, later than that of the previous pair. Returns 0, or -1 after
 * an error, which `plslam_odometry_error` states; the odometry can track the next pair. */
int plslam_odometry_track(plslam_odometry* odometry, int64_t t_ns, const plslam_image* left,
                          const plslam_image* right, plslam_pose* pose);

/* Writes the following pairs into a new folder, as a dataset: from the first pair on, `plslam run FOLDER --no-mapping`
 * reproduces the poses (options: --config FOLDER/options.yaml). Masks of the calibration are left out. NULL ends it.
 * Returns 0, or -1 after an error. A pair that cannot be written is an error of `plslam_odometry_track`. */
int plslam_odometry_record(plslam_odometry* odometry, const char* folder);

/* Returns the sentence of the last error, "" if there was none; valid until the next call. */
const char* plslam_odometry_error(const plslam_odometry* odometry);

#ifdef __cplusplus
}
#endif
