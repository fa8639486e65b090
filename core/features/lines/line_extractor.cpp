// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_extractor.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/features/image/gradients.h"
#include "core/features/lines/coarse_lines.h"
#include "core/features/lines/lbd.h"
#include "core/features/lines/line_detector.h"
#include "core/features/lines/line_select.h"

namespace plslam {

struct LineExtractor::Impl {
  explicit Impl(const LineOptions& o) : options(o), detector(MakeLineDetector(o)), coarse(*detector, options) {}

  std::vector<DetectedSegment> Segments(const cv::Mat& image) {
    std::vector<DetectedSegment> segments = MergeCollinear(detector->Detect(image, gradients));
    const auto is_short = [this](const DetectedSegment& s) { return s.segment.Length() < options.min_length_px; };
    segments.erase(std::find_if(segments.begin(), segments.end(), is_short), segments.end());
    coarse.Complete(image, gradients, segments);
    return SelectSpread(segments, image.size(), options.max_lines);
  }

  LineOptions options;
  std::unique_ptr<LineDetector> detector;
  CoarseLines coarse;
  Gradients gradients;
};

LineExtractor::LineExtractor(const LineOptions& options) : impl_(std::make_unique<Impl>(options)) {}
LineExtractor::~LineExtractor() = default;
LineExtractor::LineExtractor(LineExtractor&&) noexcept = default;
LineExtractor& LineExtractor::operator=(LineExtractor&&) noexcept = default;

std::vector<LineFeature> LineExtractor::Extract(const cv::Mat& image) {
  if (image.empty()) return {};
  if (image.type() != CV_8UC1) throw std::invalid_argument("line extraction needs an 8-bit image of one channel");
  ComputeGradients(image, impl_->gradients);
  std::vector<LineFeature> lines;
  for (const DetectedSegment& s : impl_->Segments(image)) {
    LineFeature line;
    line.segment = s.segment;
    line.octave = s.octave;
    line.response = static_cast<float>(s.contrast);
    line.descriptor = ComputeLbd(impl_->gradients, s.segment);
    lines.push_back(line);
  }
  return lines;
}

}  // namespace plslam
