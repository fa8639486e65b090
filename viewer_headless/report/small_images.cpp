// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/small_images.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/geometry/rectifier.h"

namespace plslam::viewer {
namespace {

cv::Size SmallSize(const cv::Size& size, int width_px) {
  if (size.width <= width_px) return size;
  return {width_px, std::max(1, size.height * width_px / size.width)};
}

int BlockOf(const cv::Size& size, int width_px) { return std::max(1, std::min(size.width / width_px, size.height)); }

cv::Mat MeansOfBlocks(const cv::Mat& image, int block) {
  if (block == 1) return image;
  const cv::Size blocks(image.cols / block, image.rows / block);
  cv::Mat means;
  cv::resize(image({0, 0, blocks.width * block, blocks.height * block}), means, blocks, 0, 0, cv::INTER_AREA);
  return means;
}

/// Returns a coordinate in the image whose pixels are `block` times as large, in subpixels, clamped to its `size`.
int InBlocks(double raw_px, int block, int size) {
  const double px = std::clamp((raw_px + 0.5) / block - 0.5, 0.0, size - 1.0);
  return static_cast<int>(std::lround(px * BilinearWarp::kSubpixels));
}

}  // namespace

cv::Mat Shrink(const cv::Mat& image, int width_px) {
  if (image.cols <= width_px) return image;
  cv::Mat small;
  cv::resize(MeansOfBlocks(image, BlockOf(image.size(), width_px)), small, SmallSize(image.size(), width_px), 0, 0,
             cv::INTER_LINEAR);
  return small;
}

SmallRectifier::SmallRectifier(const Rectification& rectification, const RectifiedView& view, const char* side,
                               int width_px)
    : calibration_(view.calibration()), side_(side), width_px_(width_px) {
  const StereoCamera& camera = rectification.camera;
  const cv::Size whole(camera.width_px, camera.height_px), raw(calibration_.width_px, calibration_.height_px);
  block_ = BlockOf(whole, width_px);
  if (rectification.identity) return;
  const cv::Size source(raw.width / block_, raw.height / block_);
  const cv::Size small = SmallSize(whole, width_px);
  warp_.emplace(source, small);
  std::vector<double> xs(small.width);
  std::vector<double> ys(small.width);
  for (int v = 0; v < small.height; ++v) {
    std::iota(xs.begin(), xs.end(), 0.0);
    for (double& x : xs) x = (x + 0.5) * whole.width / small.width - 0.5;
    std::fill(ys.begin(), ys.end(), (v + 0.5) * whole.height / small.height - 0.5);
    view.ToRawPixels(camera, xs, ys);
    for (int u = 0; u < small.width; ++u) {
      const bool inside = xs[u] >= -0.5 && ys[u] >= -0.5 && xs[u] <= raw.width - 0.5 && ys[u] <= raw.height - 0.5;
      if (!inside) continue;
      warp_->SetSource(u, v, InBlocks(xs[u], block_, source.width), InBlocks(ys[u], block_, source.height));
    }
  }
}

cv::Mat SmallRectifier::Apply(const cv::Mat& image) const {
  CheckImage(image, CV_8UC1, calibration_, side_);
  return warp_ ? warp_->Apply(MeansOfBlocks(image, block_)) : Shrink(image, width_px_);
}

}  // namespace plslam::viewer
