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
#include <vector>

namespace plslam::robot {

enum class Side { kLeft = 0, kRight = 1 };

/// Pairs left and right images by their stamps, in any order of arrival, up to 1.5 s later: a busy robot, or a log of
/// one, may delay messages for so long. An image whose partner has not arrived when a later pair is complete, after
/// that time, or when too many wait, stays unpaired and is counted.
///
/// Stamps of a pair differ by `max_skew_ns` at most, and by no more than half of the period of the images (the median
/// of the last steps of a side, the smaller one of the two): beyond that, another image of the partner's side is nearer,
/// and one lost image would shift all later pairs by one.
template <class Image>
class StampPairing {
 public:
  explicit StampPairing(int64_t max_skew_ns) : max_skew_ns_(max_skew_ns) {}

  /// Left and right image, where `image` completes a pair. `Image::t_ns` is its stamp, not negative.
  std::optional<std::pair<Image, Image>> Add(Side side, Image image) {
    std::deque<Image>& own = waiting_[static_cast<size_t>(side)];
    std::deque<Image>& others = waiting_[1 - static_cast<size_t>(side)];
    steps_[static_cast<size_t>(side)].Add(image.t_ns);
    const auto skew = [&](const Image& other) { return std::abs(other.t_ns - image.t_ns); };
    const auto nearest = std::min_element(others.begin(), others.end(),
                                          [&](const Image& a, const Image& b) { return skew(a) < skew(b); });
    if (nearest == others.end() || skew(*nearest) > LargestSkew_ns()) {
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

  /// The newest steps between the stamps of a side.
  class Steps {
   public:
    void Add(int64_t t_ns) {
      const std::optional<int64_t> before_ns = std::exchange(newest_t_ns_, t_ns);
      if (!before_ns || t_ns <= *before_ns) return;
      steps_ns_.push_back(t_ns - *before_ns);
      if (steps_ns_.size() > kMost) steps_ns_.pop_front();
    }
    /// Returns nullopt before the second image.
    std::optional<int64_t> Median_ns() const {
      if (steps_ns_.empty()) return std::nullopt;
      std::vector<int64_t> sorted(steps_ns_.begin(), steps_ns_.end());
      const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
      std::nth_element(sorted.begin(), middle, sorted.end());
      return *middle;
    }

   private:
    static constexpr size_t kMost = 15;
    std::optional<int64_t> newest_t_ns_;
    std::deque<int64_t> steps_ns_;
  };

  int64_t LargestSkew_ns() const {
    int64_t largest_ns = max_skew_ns_;
    for (const Steps& steps : steps_) {
      if (const auto period_ns = steps.Median_ns()) largest_ns = std::min(largest_ns, *period_ns / 2);
    }
    return largest_ns;
  }

  void Drop(std::deque<Image>& images, typename std::deque<Image>::iterator end) {
    unpaired_ += end - images.begin();
    images.erase(images.begin(), end);
  }

  int64_t max_skew_ns_;
  std::array<Steps, 2> steps_;
  std::array<std::deque<Image>, 2> waiting_;
  int64_t unpaired_ = 0;
};

}  // namespace plslam::robot
