// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/absolute_error.h"

#include <cmath>

namespace plslam {

double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

AbsoluteErrors ComputeAbsoluteErrors(const PosePairs& pairs, const Similarity& alignment) {
  AbsoluteErrors errors;
  for (const PosePair& pair : pairs) {
    const SE3 aligned = alignment.Apply(pair.estimate);
    errors.translation_m.push_back((aligned.translation() - pair.truth.translation()).norm());
    errors.rotation_rad.push_back(AngleBetween(aligned.rotation(), pair.truth.rotation()));
  }
  return errors;
}

}  // namespace plslam
