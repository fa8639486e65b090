// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>

#include "viewer_headless/overlay.h"
#include "viewer_headless/recorder.h"

namespace plslam {

/// Brings together the parts of a picture, which come in messages of their own, in any order, or never.
class OverlayQueue {
 public:
  struct Ready {
    FramePose pose;
    cv::Mat image;
    cv::Mat right;
    OverlayFeatures features;
  };

  /// `every` N frames; 0: none.
  explicit OverlayQueue(int64_t every) : every_(every) {}

  bool Wants(int64_t frame_id) const { return every_ > 0 && frame_id >= 0 && frame_id % every_ == 0; }

  /// Each adds one part of a wanted frame (others are ignored). Of frames that stay incomplete the oldest are
  /// dropped: 1024 wait at most, with 64 MB of images. The right image comes with the left one, where somebody has a
  /// use for it.
  void AddImage(int64_t frame_id, const cv::Mat& image, const cv::Mat& right = {});
  void AddFeatures(int64_t frame_id, OverlayFeatures features);
  /// Once for each frame.
  void AddPose(const FramePose& pose);
  /// The oldest picture that is complete, which is not waited for any more.
  std::optional<Ready> Next();

  /// Wanted frames whose pose has come, and whose picture has not been taken.
  const std::set<int64_t>& lacking() const { return lacking_; }
  /// Oldest frame whose image has come; images of frames before it were sent before anybody listened here.
  std::optional<int64_t> first_image() const { return first_image_; }

 private:
  struct Parts {
    std::optional<FramePose> pose;
    cv::Mat image;
    cv::Mat right;
    std::optional<OverlayFeatures> features;

    size_t image_bytes() const { return image.total() * image.elemSize() + right.total() * right.elemSize(); }
  };

  void Took(int64_t frame_id);
  void Drop(std::map<int64_t, Parts>::iterator parts);

  int64_t every_;
  std::map<int64_t, Parts> waiting_;
  std::set<int64_t> complete_;
  std::set<int64_t> lacking_;
  std::optional<int64_t> first_image_;
  size_t image_bytes_ = 0;
};

}  // namespace plslam
