// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "core/run/recorder.h"

namespace plslam::viewer {

/// A tracked point of the rectified left image.
struct OverlayPoint {
  cv::Point2f px;
  float disparity_px = -1.0F;  ///< < 0: no depth
  int age = 0;                 ///< frames its landmark has been seen in
  bool moving = false;         ///< on a moving body
};

/// A tracked line segment of the rectified left image.
struct OverlaySegment {
  cv::Point2f p_px;
  cv::Point2f q_px;
  float disparity_p_px = -1.0F;  ///< both < 0: no depth
  float disparity_q_px = -1.0F;
  int age = 0;
  bool moving = false;

  bool HasDepth() const { return disparity_p_px >= 0.0F && disparity_q_px >= 0.0F; }
};

struct OverlayFeatures {
  std::vector<OverlayPoint> points;
  std::vector<OverlaySegment> segments;
};

/// The image in grey with the features on it, and below it a bar with the caption and the key of the colours; 8-bit
/// BGR. Segments are thick and coloured by age, those without depth thin, grey and dashed; points are circles coloured
/// by disparity (red near, blue far; white on moving bodies), small ones with age 0, grey ones without depth. Features
/// with coordinates that are not finite or far outside are left out. `image` is 8-bit grey. It is shaded where `mask`
/// is 0, where no features are detected; an empty mask is that of a camera that uses all pixels.
cv::Mat DrawOverlay(const cv::Mat& image, const OverlayFeatures& features, const std::string& caption,
                    const cv::Mat& mask = cv::Mat());

/// Combines the parts of a picture, which arrive in separate messages, in any order, or never.
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

  bool Wants(FrameId frame_id) const { return every_ > 0 && frame_id >= 0 && frame_id.value % every_ == 0; }

  /// Each adds one part of a wanted frame (others are ignored). The oldest incomplete frames are dropped: at most 1024
  /// frames with 64 MB of images wait. The right image is given with the left one if it is needed.
  void AddImage(FrameId frame_id, const cv::Mat& image, const cv::Mat& right = {});
  void AddFeatures(FrameId frame_id, OverlayFeatures features);
  /// Adds the pose of a frame; once for each frame.
  void AddPose(const FramePose& pose);
  /// Removes and returns the oldest complete picture.
  std::optional<Ready> Next();

  /// Wanted frames that have a pose, and whose picture has not been taken.
  const std::set<FrameId>& lacking() const { return lacking_; }
  /// Oldest frame with an image; images of frames before it were sent before this process listened.
  std::optional<FrameId> first_image() const { return first_image_; }

 private:
  struct Parts {
    std::optional<FramePose> pose;
    cv::Mat image;
    cv::Mat right;
    std::optional<OverlayFeatures> features;

    size_t image_bytes() const { return image.total() * image.elemSize() + right.total() * right.elemSize(); }
  };

  void Took(FrameId frame_id);
  void Drop(std::map<FrameId, Parts>::iterator parts);

  int64_t every_;
  std::map<FrameId, Parts> waiting_;
  std::set<FrameId> complete_;
  std::set<FrameId> lacking_;
  std::optional<FrameId> first_image_;
  size_t image_bytes_ = 0;
};

}  // namespace plslam::viewer
