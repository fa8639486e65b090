// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/kitti_error.h"

#include <algorithm>
#include <cmath>

#include "tools/evaluate/relative_error.h"

namespace plslam {
namespace {

// The kit takes the angle from the trace of the rotation matrix, clamped.
double RotationAngle(const SE3& T) {
  const double cosine = 0.5 * (T.R().trace() - 1.0);
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

double DegPer100m(double rad_per_m) { return rad_per_m * 180.0 / M_PI * 100.0; }

struct Sums {
  int n = 0;
  double t = 0.0;  // metre per metre
  double r = 0.0;  // radian per metre
};

Sums SumOverStarts(const PosePairs& pairs, const std::vector<double>& path_m, double length_m, int step) {
  Sums sums;
  for (size_t first = 0; first < pairs.size(); first += static_cast<size_t>(step)) {
    const auto last = std::upper_bound(path_m.begin(), path_m.end(), path_m[first] + length_m);
    if (last == path_m.end()) break;
    const PosePair& a = pairs[first];
    const PosePair& b = pairs[static_cast<size_t>(last - path_m.begin())];
    const SE3 error = (a.estimate.Inverse() * b.estimate).Inverse() * (a.truth.Inverse() * b.truth);
    ++sums.n;
    sums.t += error.translation().norm() / length_m;
    sums.r += RotationAngle(error) / length_m;
  }
  return sums;
}

}  // namespace

KittiErrors ComputeKittiErrors(const PosePairs& pairs, const std::vector<double>& lengths_m, int step) {
  const std::vector<double> path_m = TruePath_m(pairs);
  KittiErrors result;
  Sums all;
  for (const double length_m : lengths_m) {
    const Sums sums = SumOverStarts(pairs, path_m, length_m, step);
    if (sums.n == 0) continue;
    result.lengths.push_back({length_m, sums.n, 100.0 * sums.t / sums.n, DegPer100m(sums.r / sums.n)});
    all.n += sums.n;
    all.t += sums.t;
    all.r += sums.r;
  }
  result.segments = all.n;
  if (all.n == 0) return result;
  result.t_rel_percent = 100.0 * all.t / all.n;
  result.r_rel_deg_per_100m = DegPer100m(all.r / all.n);
  return result;
}

KittiErrors ComputeKittiErrors(const PosePairs& pairs) {
  return ComputeKittiErrors(pairs, {100, 200, 300, 400, 500, 600, 700, 800}, 10);
}

KittiErrors ComputeShortKittiErrors(const PosePairs& pairs) {
  return ComputeKittiErrors(pairs, {10, 20, 30, 40, 50}, 1);
}

}  // namespace plslam
