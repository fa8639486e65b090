#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "viewer_headless/overlay.h"

namespace plslam {

/// Brings together the parts of a picture, which come in messages of their own, in any order, or never.
class OverlayQueue {
 public:
  struct Ready {
    int64_t frame_id = 0;
    cv::Mat image;
    OverlayFeatures features;
    std::string caption;
  };

  /// `every` N frames; 0: none.
  explicit OverlayQueue(int64_t every) : every_(every) {}

  bool Wants(int64_t frame_id) const { return every_ > 0 && frame_id >= 0 && frame_id % every_ == 0; }

  /// Each adds one part of a wanted frame (others are ignored) and returns the picture it completes. Of frames that
  /// stay incomplete the oldest are dropped: eight wait at most.
  std::optional<Ready> AddImage(int64_t frame_id, const cv::Mat& image);
  std::optional<Ready> AddFeatures(int64_t frame_id, OverlayFeatures features);
  std::optional<Ready> AddCaption(int64_t frame_id, std::string caption);

 private:
  struct Parts {
    cv::Mat image;
    std::optional<OverlayFeatures> features;
    std::optional<std::string> caption;
  };

  std::optional<Ready> Take(int64_t frame_id);

  int64_t every_;
  std::map<int64_t, Parts> waiting_;
};

}  // namespace plslam
