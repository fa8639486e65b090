// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

/* Returns 1 if the pair became the first keyframe, 0 after an error. */
int TrackOnePairInC(const char* calibration, const void* left, const void* right, int width_px, int height_px);

#ifdef __cplusplus
}
#endif
