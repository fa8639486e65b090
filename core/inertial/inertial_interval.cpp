// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/inertial_interval.h"

namespace plslam {

void InertialInterval::Append(std::span<const ImuSample> more, int64_t until_ns) {
  for (const ImuSample& sample : more) {
    if (samples.empty() || sample.t_ns > samples.back().t_ns) samples.push_back(sample);
  }
  to_ns = until_ns;
}

}  // namespace plslam
