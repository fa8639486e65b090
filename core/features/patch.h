#pragma once

#include <Eigen/Core>

namespace plslam {

// Square patches of grey levels for alignment; used by patch_aligner.cpp, patch_tracker.cpp and slant_refiner.cpp only.

inline constexpr int kHalf = 5;
inline constexpr int kSide = 2 * kHalf + 1;
inline constexpr int kRow = 12;  // a row of the patch and one column of weight 0, for whole vector registers
inline constexpr int kPixels = kSide * kSide;
/// Grey levels; quantisation and sensor noise hardly go below this.
inline constexpr double kMinNoise = 1.0;
/// Steps below this, in pixels of the patch, end a search.
inline constexpr double kPatchConverged = 0.01;

/// Column-major, so one image row is one column here.
using Patch = Eigen::Array<float, kRow, kSide>;

inline float Dot(const Patch& a, const Patch& b) { return (a * b).sum(); }

inline void RemoveMean(Patch& p) {
  const float mean = p.sum() / kPixels;
  p.topRows<kSide>() -= mean;
}

}  // namespace plslam
