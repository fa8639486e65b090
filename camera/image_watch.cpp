// SPDX-License-Identifier: BSD-3-Clause
#include "camera/image_watch.h"

#include <fmt/format.h>

#include <algorithm>

namespace plslam::camera {

void ImageWatch::OnImage(Side side, Time now) {
  last_images_[static_cast<size_t>(side)] = waits_since_ = now;
  gave_images_ = true;
}

bool ImageWatch::SentSince(Side side, Time since) const {
  const std::optional<Time>& last = last_images_[static_cast<size_t>(side)];
  return last && *last > since;
}

std::string ImageWatch::Silence(Time now, std::chrono::nanoseconds period) const {
  const Time since =
      now - std::max<std::chrono::nanoseconds>(gave_images_ ? kSilence : kFirstSilence, kSilentPeriods * period);
  if (std::max(last_frame_, played_) > since) return "";
  const bool left = SentSince(Side::kLeft, since), right = SentSince(Side::kRight, since);
  if (left != right) return fmt::format("the {} camera sends no images", left ? "right" : "left");
  return left ? "left and right images have no times in common (source.max_skew_ms)" : "the cameras send no images";
}

}  // namespace plslam::camera
