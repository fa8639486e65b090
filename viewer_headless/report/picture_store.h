// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// The pictures of a run, as many as fit into a report. They contain the left image of every `stride`-th frame with its
/// features, and its right image, smaller; the stride doubles whenever there are more than `max_pictures`. A smaller
/// image of every keyframe is stored for the pairs of loops; beyond `kMaxKeyframes` every second one is dropped.
class PictureStore {
 public:
  static constexpr int kPictureWidth_px = 512;
  /// Rarely viewed: at half the width, right images make the report a third larger.
  static constexpr int kRightWidth_px = kPictureWidth_px / 2;

  explicit PictureStore(int64_t max_pictures) : max_pictures_(max_pictures) {}

  /// The stream is going to have so many frames: chooses the stride that will fit.
  void Announce(int64_t n_frames);
  bool Wants(FrameId frame_id) const { return max_pictures_ > 0 && frame_id >= 0 && frame_id.value % stride_ == 0; }
  int64_t stride() const { return stride_; }

  /// Adds rectified images, 8-bit grey, which may be smaller than the `width_px` of the image that has the features;
  /// `right` may be empty.
  void Add(FrameId frame_id, const cv::Mat& left, const cv::Mat& right, const OverlayFeatures& features,
           int width_px);
  void AddKeyframe(FrameId frame_id, const cv::Mat& image);

  /// Sets the number of wanted pictures that are missing.
  void SetMissing(int64_t n) { missing_ = n; }
  int64_t missing() const { return missing_; }

  const std::map<FrameId, ReportPicture>& pictures() const { return pictures_; }
  /// Returns the JPEG of the keyframe at that frame; empty if there is none.
  std::string Keyframe(FrameId frame_id) const;

 private:
  static constexpr size_t kMaxKeyframes = 2000;

  int64_t max_pictures_;
  int64_t stride_ = 1;
  int64_t missing_ = 0;
  std::map<FrameId, ReportPicture> pictures_;
  std::map<FrameId, std::string> keyframes_;
};

}  // namespace plslam::viewer
