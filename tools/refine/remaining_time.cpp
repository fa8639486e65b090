// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/remaining_time.h"

#include <algorithm>
#include <cmath>

namespace plslam::refine {
namespace {

constexpr double kTolerance = 1e-6;
// Iterations of a solve of which nothing is known yet, and the most that are expected.
constexpr double kUsual = 8.0;
constexpr double kMost = 50.0;

}  // namespace

double RemainingTime::After(int iteration, double cost, double elapsed_s) {
  if (iteration == 0) {
    ended_iterations_ += iteration_;
    ++begun_;
    gain_ = 0.0;
    left_ = IterationsOfOthers();
  } else {
    const double gain = cost_ > 0.0 ? (cost_ - cost) / cost_ : 0.0;
    left_ = std::max(0.0, left_ - 1.0);
    // A rejected step gains nothing, and tells nothing.
    if (gain > 0.0) {
      const double factor = gain_ > 0.0 ? std::clamp(gain / gain_, 0.05, 0.95) : 0.3;
      left_ = gain <= kTolerance ? 0.0 : std::min(kMost, std::ceil(std::log(kTolerance / gain) / std::log(factor)));
      gain_ = gain;
    }
  }
  iteration_ = iteration;
  cost_ = cost;
  const double done = ended_iterations_ + iteration_;
  if (done < 1.0) return 0.0;
  const double left = left_ + std::max(0, solves_ - begun_) * IterationsOfOthers();
  return left * elapsed_s / done;
}

double RemainingTime::IterationsOfOthers() const {
  return begun_ > 1 ? static_cast<double>(ended_iterations_) / (begun_ - 1) : kUsual;
}

}  // namespace plslam::refine
