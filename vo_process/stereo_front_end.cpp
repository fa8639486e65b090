#include "vo_process/stereo_front_end.h"

#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/features/stereo_matcher.h"

namespace plslam {
namespace {

// Descriptors and gradients reach this far around a feature.
constexpr int kMaskMargin_px = 8;

cv::Mat Shrink(const cv::Mat& mask) {
  if (mask.empty()) return mask;
  cv::Mat shrunk;
  const int size = 2 * kMaskMargin_px + 1;
  cv::erode(mask, shrunk, cv::Mat::ones(size, size, CV_8U), cv::Point(-1, -1), 1, cv::BORDER_CONSTANT,
            cv::Scalar(255));
  return shrunk;
}

bool IsMasked(const cv::Mat& mask, const Eigen::Vector2d& px) {
  const int u = static_cast<int>(std::lround(px.x()));
  const int v = static_cast<int>(std::lround(px.y()));
  return u < 0 || v < 0 || u >= mask.cols || v >= mask.rows || mask.at<uchar>(v, u) == 0;
}

ImageFeatures ExtractInside(FeatureExtractor& extractor, const cv::Mat& image, const cv::Mat& mask) {
  ImageFeatures features = extractor.Extract(image);
  if (mask.empty()) return features;
  std::erase_if(features.points, [&](const PointFeature& point) { return IsMasked(mask, point.px); });
  std::erase_if(features.lines, [&](const LineFeature& line) {
    const Eigen::Vector2d middle = 0.5 * (line.segment.p + line.segment.q);
    return IsMasked(mask, line.segment.p) || IsMasked(mask, line.segment.q) || IsMasked(mask, middle);
  });
  return features;
}

}  // namespace

StereoFrontEnd::StereoFrontEnd(const RigCalibration& rig, const VoOptions& options)
    : rig_(rig),
      options_(options),
      rectifier_(rig),
      left_mask_(Shrink(rectifier_.left_mask())),
      right_mask_(Shrink(rectifier_.right_mask())),
      left_extractor_(options.features),
      right_extractor_(options.features) {}

StereoFeatures StereoFrontEnd::Process(const StereoImages& images, StageTimer& timer) {
  left_ = {};
  const bool rgbd = rig_.kind == RigCalibration::Kind::kRgbd;
  return rgbd ? ProcessRgbd(images, timer) : ProcessStereo(images, timer);
}

void StereoFrontEnd::KeepLeft(const cv::Mat& left) {
  if (options_.refinement.enabled && options_.features.features != "lines") left_ = ImageLevels(left);
}

StereoFeatures StereoFrontEnd::ProcessStereo(const StereoImages& images, StageTimer& timer) {
  cv::Mat left;
  cv::Mat right;
  timer.Time("rectify", [&] {
    worker_.RunBoth([&] { left = rectifier_.RectifyLeft(images.left); },
                    [&] { right = rectifier_.RectifyRight(images.right); });
  });
  ImageFeatures left_features;
  ImageFeatures right_features;
  timer.Time("features", [&] {
    worker_.RunBoth([&] { left_features = ExtractInside(left_extractor_, left, left_mask_); },
                    [&] { right_features = ExtractInside(right_extractor_, right, right_mask_); });
  });
  return timer.Time("stereo", [&] {
    KeepLeft(left);
    return MatchStereo(std::move(left_features), right_features, left, right, camera(), options_.stereo,
                       [this](const auto& here, const auto& there) { worker_.RunBoth(here, there); });
  });
}

StereoFeatures StereoFrontEnd::ProcessRgbd(const StereoImages& images, StageTimer& timer) {
  cv::Mat left;
  cv::Mat depth;
  timer.Time("rectify", [&] {
    worker_.RunBoth([&] { left = rectifier_.RectifyLeft(images.left); },
                    [&] { depth = rectifier_.RectifyDepth(images.right); });
  });
  ImageFeatures features = timer.Time("features", [&] { return ExtractInside(left_extractor_, left, left_mask_); });
  return timer.Time("stereo", [&] {
    KeepLeft(left);
    return AttachDepth(std::move(features), depth, rig_.depth_units_per_m, camera(), options_.stereo);
  });
}

}  // namespace plslam
