// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/feature_extractor.h"

#include <utility>

#include "core/features/lines/line_extractor.h"
#include "core/features/points/orb_extractor.h"

namespace plslam {

struct FeatureExtractor::Impl {
  explicit Impl(const FeatureOptions& options)
      : with_points(options.features != "lines"),
        with_lines(options.features != "points"),
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
