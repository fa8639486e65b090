// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/rectifier.h"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/geometry/image_mask.h"

namespace plslam {
namespace {

constexpr int kSubpixels = BilinearWarp::kSubpixels;

// Outside every image, so that the remapping writes its border value.
constexpr int16_t kNowhere = -2;

int16_t ToInt16(int value) { return static_cast<int16_t>(value); }

/// Rounds numbers that are not negative; lround would take as long as everything else.
int Rounded(double value) {
  const double up = value + 0.5;
  return static_cast<int>(up);
}

}  // namespace

void CheckImage(const cv::Mat& image, int type, const CameraCalibration& calibration, const char* side) {
  if (image.type() == type && image.cols == calibration.width_px && image.rows == calibration.height_px) return;
  std::ostringstream text;
  text << "the " << side << " image is " << image.cols << "x" << image.rows << " of type "
       << (image.empty() ? "nothing" : cv::typeToString(image.type())) << ", the calibration states "
       << calibration.width_px << "x" << calibration.height_px << " of type " << cv::typeToString(type);
  throw std::runtime_error(text.str());
}

Rectifier::Rectifier(const RigCalibration& rig) : rectification_(Rectify(rig)) {
  const bool stereo = rig.kind == RigCalibration::Kind::kStereo;
  const cv::Mat left_in_use = DrawMask(rig.left);
  const cv::Mat right_in_use = DrawMask(rig.right);
  if (rectification_.identity) {
    left_.mask = left_in_use;
    right_.mask = right_in_use;
    return;
  }
  left_ = MakeMaps(rectification_.left, left_in_use, !stereo);
  if (stereo) right_ = MakeMaps(rectification_.right, right_in_use, false);
}

/// `in_use` is the mask of the raw image, or empty.
Rectifier::Maps Rectifier::MakeMaps(const RectifiedView& view, const cv::Mat& in_use, bool with_nearest) const {
  const StereoCamera& c = rectification_.camera;
  const cv::Size size(c.width_px, c.height_px);
  const double raw_width = view.calibration().width_px, raw_height = view.calibration().height_px;
  Maps maps{BilinearWarp({view.calibration().width_px, view.calibration().height_px}, size), cv::Mat(),
            cv::Mat(size, CV_8UC1, cv::Scalar(0))};
  if (with_nearest) maps.nearest = cv::Mat(c.height_px, c.width_px, CV_16SC2, cv::Scalar::all(kNowhere));
  bool everywhere = true;
  std::vector<double> xs(c.width_px);
  std::vector<double> ys(c.width_px);
  for (int v = 0; v < c.height_px; ++v) {
    std::iota(xs.begin(), xs.end(), 0.0);
    std::fill(ys.begin(), ys.end(), v);
    view.ToRawPixels(c, xs, ys);
    for (int u = 0; u < c.width_px; ++u) {
      // Half a pixel beyond the centres of the border pixels still belongs to the image, as a repeated pixel.
      const bool inside = xs[u] >= -0.5 && ys[u] >= -0.5 && xs[u] <= raw_width - 0.5 && ys[u] <= raw_height - 0.5;
      everywhere = everywhere && inside;
      if (!inside) continue;
      const double x = std::clamp(xs[u], 0.0, raw_width - 1.0);
      const double y = std::clamp(ys[u], 0.0, raw_height - 1.0);
      maps.warp->SetSource(u, v, Rounded(x * kSubpixels), Rounded(y * kSubpixels));
      const bool left_out = !in_use.empty() && in_use.at<uint8_t>(Rounded(y), Rounded(x)) == 0;
      everywhere = everywhere && !left_out;
      if (!left_out) maps.mask.at<uint8_t>(v, u) = 255;
      if (with_nearest) maps.nearest.at<cv::Vec2s>(v, u) = {ToInt16(Rounded(x)), ToInt16(Rounded(y))};
    }
  }
  if (everywhere) maps.mask.release();
  return maps;
}

cv::Mat Rectifier::LeftMask(const cv::Mat& in_use) const { return MaskWith(left_, in_use); }
cv::Mat Rectifier::RightMask(const cv::Mat& in_use) const { return MaskWith(right_, in_use); }

cv::Mat Rectifier::MaskWith(const Maps& maps, const cv::Mat& in_use) const {
  if (in_use.empty()) return maps.mask;
  // A pixel with a masked source pixel is masked.
  cv::Mat mask = maps.warp ? cv::Mat(maps.warp->Apply(in_use) == 255) : in_use.clone();
  if (!maps.mask.empty()) cv::bitwise_and(mask, maps.mask, mask);
  return mask;
}

cv::Mat Rectifier::RectifyLeft(const cv::Mat& image) const {
  CheckImage(image, CV_8UC1, rectification_.left.calibration(), "left");
  if (rectification_.identity) return image;
  return left_.warp->Apply(image);
}

cv::Mat Rectifier::RectifyRight(const cv::Mat& image) const {
  CheckImage(image, CV_8UC1, rectification_.right.calibration(), "right");
  if (rectification_.identity) return image;
  CV_Assert(right_.warp);
  return right_.warp->Apply(image);
}

cv::Mat Rectifier::RectifyDepth(const cv::Mat& depth) const {
  CheckImage(depth, CV_16UC1, rectification_.left.calibration(), "depth");
  if (rectification_.identity) return depth;
  cv::Mat result;
  cv::remap(depth, result, left_.nearest, cv::Mat(), cv::INTER_NEAREST, cv::BORDER_CONSTANT, cv::Scalar(0));
  return result;
}

}  // namespace plslam
