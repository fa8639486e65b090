// SPDX-License-Identifier: BSD-3-Clause
#include "camera/pairing.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace plslam::camera {
namespace {

/// Waiting images of one camera while the other one delivers none.
constexpr size_t kMostWaiting = 32;
/// A single short step, as of a transfer that was held up, delays pairs for so many images.
constexpr size_t kMostSteps = 100;

}  // namespace

int64_t Pairing::Camera::ShortestStep_ns() const {
  return steps_ns.empty() ? 0 : *std::ranges::min_element(steps_ns);
}

void Pairing::Drop(Camera* camera) {
  camera->images.pop_front();
  if (had_pair_) ++camera->dropped;
}

void Pairing::Add(Side side, CapturedImage image) {
  Camera& camera = Of(side);
  if (image.t_ns <= camera.newest_t_ns) {
    ++camera.dropped;
    return;
  }
  if (camera.newest_t_ns != std::numeric_limits<int64_t>::min()) {
    camera.steps_ns.push_back(image.t_ns - camera.newest_t_ns);
    if (camera.steps_ns.size() > kMostSteps) camera.steps_ns.pop_front();
  }
  camera.newest_t_ns = image.t_ns;
  camera.images.push_back(std::move(image));
  if (camera.images.size() > kMostWaiting) Drop(&camera);
}

bool Pairing::End(Side side) { return !std::exchange(Of(side).ended, true); }

void Pairing::Clear() {
  for (Camera& camera : cameras_) {
    const int64_t dropped = camera.dropped;
    camera = {};
    camera.dropped = dropped;
  }
}

Pairing::Decision Pairing::Decide(const Camera& earlier, const Camera& later) const {
  const int64_t t_ns = later.images.front().t_ns;
  const int64_t skew_ns = t_ns - earlier.images.front().t_ns;
  if (skew_ns > max_skew_ns_) return Decision::kDropEarlier;
  if (earlier.images.size() > 1) {
    return std::abs(earlier.images[1].t_ns - t_ns) < skew_ns ? Decision::kDropEarlier : Decision::kPair;
  }
  // The next image of the earlier camera would have to arrive within this time to be nearer.
  const bool is_nearest = skew_ns == 0 || (is_live_ && 2 * skew_ns <= earlier.ShortestStep_ns());
  return is_nearest || earlier.ended ? Decision::kPair : Decision::kUnknown;
}

std::optional<CapturedPair> Pairing::Pop() {
  Camera& left = Of(Side::kLeft);
  Camera& right = Of(Side::kRight);
  while (!left.images.empty() && !right.images.empty()) {
    const bool left_first = left.images.front().t_ns <= right.images.front().t_ns;
    Camera& earlier = left_first ? left : right;
    const Decision decision = Decide(earlier, left_first ? right : left);
    if (decision == Decision::kUnknown) return std::nullopt;
    if (decision == Decision::kPair) {
      had_pair_ = true;
      CapturedPair pair{std::move(left.images.front()), std::move(right.images.front())};
      left.images.pop_front();
      right.images.pop_front();
      return pair;
    }
    Drop(&earlier);
  }
  return std::nullopt;
}

}  // namespace plslam::camera
