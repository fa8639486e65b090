// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace plslam::camera {

enum class Side { kLeft = 0, kRight = 1 };

struct CapturedImage {
  int64_t t_ns = 0;
  cv::Mat pixels;
};

struct CapturedPair {
  CapturedImage left;
  CapturedImage right;
};

/// Pairs images of two cameras by their times: each with the nearest one of the other camera, at most `max_skew_ns`
/// apart. Images without a partner are dropped, and counted from the first pair on, since cameras do not start at once.
/// Images that are not later than the previous one of their camera are dropped, too.
///
/// A pair is returned as soon as no later image can be nearer, which is known from the next image of the camera with
/// the earlier image: so the result depends on the order in each camera only, not on the interleaving of the two. In
/// live mode it is returned at once if that camera has not taken two images within so short a time lately.
class Pairing {
 public:
  explicit Pairing(int64_t max_skew_ns, bool is_live = false) : max_skew_ns_(max_skew_ns), is_live_(is_live) {}

  void Add(Side side, CapturedImage image);
  /// Marks the end of this camera's images. Returns false if it was marked before.
  bool End(Side side);
  /// Returns the next definite pair; nullopt if images are missing.
  std::optional<CapturedPair> Pop();

  /// Images that wait for a partner.
  size_t waiting(Side side) const { return Of(side).images.size(); }
  int64_t dropped(Side side) const { return Of(side).dropped; }
  /// Drops the waiting images, which are not counted, and times; both cameras may continue.
  void Clear();

 private:
  struct Camera {
    std::deque<CapturedImage> images;
    bool ended = false;
    int64_t newest_t_ns = std::numeric_limits<int64_t>::min();
    std::deque<int64_t> steps_ns;  // the newest ones

    /// 0: not known.
    int64_t ShortestStep_ns() const;
    int64_t dropped = 0;
  };

  Camera& Of(Side side) { return cameras_[static_cast<size_t>(side)]; }
  const Camera& Of(Side side) const { return cameras_[static_cast<size_t>(side)]; }
  void Drop(Camera* camera);
  enum class Decision { kPair, kDropEarlier, kUnknown };
  Decision Decide(const Camera& earlier, const Camera& later) const;

  int64_t max_skew_ns_;
  bool is_live_;
  std::array<Camera, 2> cameras_;
  bool had_pair_ = false;
};

}  // namespace plslam::camera
