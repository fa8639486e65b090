/* SPDX-License-Identifier: BSD-3-Clause */
#ifndef PLSLAM_TESTS_HEADER_IN_C_H
#define PLSLAM_TESTS_HEADER_IN_C_H

#ifdef __cplusplus
extern "C" {
#endif

/* Returns 1 if the pair became the first keyframe, 0 after an error. */
int TrackOnePairInC(const char* calibration, const void* left, const void* right, int width_px, int height_px);

#ifdef __cplusplus
}
#endif

#endif
