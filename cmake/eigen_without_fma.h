// SPDX-License-Identifier: BSD-3-Clause
// Included by Eigen 3.4 for arm64 as EIGEN_DENSEBASE_PLUGIN, after its packets and before its matrix product. That
// product is written with fused multiply-add there, whatever the compiler's options, and in panels of another width
// than on amd64, whose sums have another order. Here it becomes the one of amd64.
#undef EIGEN_HAS_SINGLE_INSTRUCTION_MADD
#define vfmaq_n_f32(c, a, b) vaddq_f32(c, vmulq_n_f32(a, b))
#define vfmaq_n_f64(c, a, b) vaddq_f64(c, vmulq_n_f64(a, b))
#define vfmaq_laneq_f32(c, a, b, lane) vaddq_f32(c, vmulq_laneq_f32(a, b, lane))
#define vfmaq_laneq_f64(c, a, b, lane) vaddq_f64(c, vmulq_laneq_f64(a, b, lane))
