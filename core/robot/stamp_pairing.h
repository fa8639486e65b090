// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <optional>
#include <utility>

namespace plslam::robot {

enum class Side { kLeft = 0, kRight = 1 };

/// Pairs left and right images by their stamps, in any order of arrival, up to 1.5 s later: a busy robot, or a log of
/// one, may delay messages for so long. An image whose partner has not arrived when a later pair is complete, after
/// that time, or when too many wait, stays unpaired and is counted.
template <class Image>
class StampPairing {
 public:
  explicit StampPairing(int64_t max_skew_ns) : max_skew_ns_(max_skew_ns) {}

  /// Left and right image, where `image` completes a pair. `Image::t_ns` is its stamp, not negative.
  std::optional<std::pair<Image, Image>> Add(Side side, Image image) {
    std::deque<Image>& own = waiting_[static_cast<size_t>(side)];
    std::deque<Image>& others = waiting_[1 - static_cast<size_t>(side)];
    const auto skew = [&](const Image& other) { return std::abs(other.t_ns - image.t_ns); };
    const auto nearest = std::min_element(others.begin(), others.end(),
                                          [&](const Image& a, const Image& b) { return skew(a) < skew(b); });
    if (nearest == others.end() || skew(*nearest) > max_skew_ns_) {
      own.push_back(std::move(image));
      while (own.size() > kMaxWaiting || own.back().t_ns - own.front().t_ns > kLongestDelay_ns) {
        Drop(own, own.begin() + 1);
      }
      return std::nullopt;
    }
    Image partner = std::move(*nearest);
    Drop(others, nearest);
    others.pop_front();
    Drop(own, own.end());
    if (side == Side::kRight) std::swap(image, partner);
    return std::pair(std::move(image), std::move(partner));
  }

  int64_t unpaired() const { return unpaired_; }

 private:
  static constexpr size_t kMaxWaiting = 128;
  static constexpr int64_t kLongestDelay_ns = 1'500'000'000;

  void Drop(std::deque<Image>& images, typename std::deque<Image>::iterator end) {
    unpaired_ += end - images.begin();
    images.erase(images.begin(), end);
  }

  int64_t max_skew_ns_;
  std::array<std::deque<Image>, 2> waiting_;
  int64_t unpaired_ = 0;
};

}  // namespace plslam::robot
