// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/feature_extractor.h"

#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/features/lines/line_extractor.h"
#include "core/features/points/orb_extractor.h"

namespace plslam {
namespace {

// Radius of the pixels that detectors use.
constexpr int kMaskMargin_px = 8;

}  // namespace

FeatureMask::FeatureMask(const cv::Mat& seen) {
  if (seen.empty()) return;
  const int size = 2 * kMaskMargin_px + 1;
  cv::erode(seen, inside_, cv::Mat::ones(size, size, CV_8U), cv::Point(-1, -1), 1, cv::BORDER_CONSTANT,
            cv::Scalar(255));
}

bool FeatureMask::IsOutside(const Eigen::Vector2d& px) const {
  if (inside_.empty()) return false;
  const int u = static_cast<int>(std::lround(px.x()));
  const int v = static_cast<int>(std::lround(px.y()));
  return u < 0 || v < 0 || u >= inside_.cols || v >= inside_.rows || inside_.at<uchar>(v, u) == 0;
}

bool FeatureMask::IsOutside(const Segment2& segment) const {
  return IsOutside(segment.p) || IsOutside(segment.q) || IsOutside(0.5 * (segment.p + segment.q));
}

void FeatureMask::RemoveOutside(ImageFeatures& features) const {
  if (inside_.empty()) return;
  std::erase_if(features.points, [this](const PointFeature& point) { return IsOutside(point.px); });
  std::erase_if(features.lines, [this](const LineFeature& line) { return IsOutside(line.segment); });
}

struct FeatureExtractor::Impl {
  explicit Impl(const FeatureOptions& options)
      : with_points(options.features != FeatureTypes::kLines),
        with_lines(options.features != FeatureTypes::kPoints),
        orb(options.orb),
        lines(options.lines) {}

  bool with_points;
  bool with_lines;
  OrbExtractor orb;
  LineExtractor lines;
};

FeatureExtractor::FeatureExtractor(const FeatureOptions& options) : impl_(std::make_unique<Impl>(options)) {}
FeatureExtractor::~FeatureExtractor() = default;
FeatureExtractor::FeatureExtractor(FeatureExtractor&&) noexcept = default;
FeatureExtractor& FeatureExtractor::operator=(FeatureExtractor&&) noexcept = default;

ImageFeatures FeatureExtractor::Extract(const cv::Mat& image, const RunBoth& run_both, const cv::Mat& allowed,
                                        std::optional<int> max_points) {
  ImageFeatures features;
  const auto find_points = [&] { features.points = ExtractPoints(image, allowed, max_points); };
  const auto find_lines = [&] { features.lines = ExtractLines(image); };
  if (impl_->with_points && impl_->with_lines) {
    run_both(find_points, find_lines);
  } else {
    RunInTurn(find_points, find_lines);
  }
  return features;
}

std::vector<PointFeature> FeatureExtractor::ExtractPoints(const cv::Mat& image, const cv::Mat& allowed,
                                                          std::optional<int> max_points) {
  return impl_->with_points ? impl_->orb.Extract(image, allowed, max_points) : std::vector<PointFeature>();
}

std::vector<LineFeature> FeatureExtractor::ExtractLines(const cv::Mat& image) {
  return impl_->with_lines ? impl_->lines.Extract(image) : std::vector<LineFeature>();
}

}  // namespace plslam
