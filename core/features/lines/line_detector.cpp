// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_detector.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "core/features/lines/line_grower.h"

namespace plslam {

std::unique_ptr<LineDetector> MakeLineDetector(const LineOptions& options) {
  return options.detector == Segments::kLsd ? MakeLsdDetector(options) : MakeEdgeChainDetector(options);
}

DetectedSegment Direct(const Segment2& segment, const Gradients& gradients) {
  const Eigen::Vector2d step = segment.q - segment.p;
  const double length = step.norm();
  if (!(length > 0.0) || gradients.dx.empty()) return {segment, 0.0};
  const Eigen::Vector2d normal = Eigen::Vector2d(-step.y(), step.x()) / length;
  const int samples = std::clamp(static_cast<int>(length), 2, 64);
  double sum = 0.0;
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector2d at = segment.p + (i + 0.5) / samples * step;
    const int x = std::clamp(static_cast<int>(std::lround(at.x())), 0, gradients.dx.cols - 1);
    const int y = std::clamp(static_cast<int>(std::lround(at.y())), 0, gradients.dx.rows - 1);
    sum += normal.x() * gradients.dx.at<int16_t>(y, x) + normal.y() * gradients.dy.at<int16_t>(y, x);
  }
  const double contrast = sum / (samples * static_cast<double>(Gradients::kStepGain));
  if (contrast >= 0.0) return {segment, contrast};
  return {{segment.q, segment.p}, -contrast};
}

namespace {

/// Smallest side of an image; below it OpenCV's detectors are useless, and some versions read outside the image.
constexpr int kMinSide_px = 16;

std::vector<DetectedSegment> DirectAll(const std::vector<cv::Vec4f>& raw, double offset_px,
                                       const Gradients& gradients) {
  std::vector<DetectedSegment> found;
  found.reserve(raw.size());
  for (const cv::Vec4f& r : raw) {
    const Segment2 segment{{r[0] + offset_px, r[1] + offset_px}, {r[2] + offset_px, r[3] + offset_px}};
    if (!segment.p.allFinite() || !segment.q.allFinite()) continue;
    found.push_back(Direct(segment, gradients));
  }
  return found;
}

class LsdDetector : public LineDetector {
 public:
  explicit LsdDetector(const LineOptions& options)
      : scale_(options.lsd_scale), lsd_(cv::createLineSegmentDetector(cv::LSD_REFINE_STD, options.lsd_scale)) {}

  std::vector<DetectedSegment> Detect(const cv::Mat& image, const Gradients& gradients) override {
    if (std::min(image.rows, image.cols) < kMinSide_px) return {};
    std::vector<cv::Vec4f> raw;
    lsd_->detect(image, raw);
    // OpenCV divides (x + 0.5) by the scale; its gradients, half a pixel right of x in the scaled image, correspond to
    // (x + 1) / scale - 0.5 in the input.
    return DirectAll(raw, 0.5 / scale_ - 0.5, gradients);
  }

 private:
  double scale_;
  cv::Ptr<cv::LineSegmentDetector> lsd_;
};

}  // namespace

std::unique_ptr<LineDetector> MakeLsdDetector(const LineOptions& options) {
  return std::make_unique<LsdDetector>(options);
}

namespace {

/// Seeds are on every fourth row (steep edges) or column (flat edges): any useful segment crosses several.
constexpr int kSeedStride = 4;
constexpr uint64_t kSteepSeeds = 0x0101010101010101 * kSteepEdge;
constexpr uint64_t kFlatSeeds = 0x0000000100000001 * kFlatEdge;
static_assert(std::endian::native == std::endian::little, "the first of eight marks is the lowest byte");

class EdgeChainDetector : public LineDetector {
 public:
  explicit EdgeChainDetector(const LineOptions& options)
      // A pixel of a slanted or noisy edge has less contrast than its segment.
      : threshold_(std::max(1, static_cast<int>(0.6 * options.min_contrast * Gradients::kStepGain))),
        min_contrast_(options.min_contrast) {}

  std::vector<DetectedSegment> Detect(const cv::Mat&, const Gradients& gradients) override {
    ComputeEdgeMap(gradients, threshold_, edges_);
    found_.clear();
    LineGrower grower(gradients, edges_, min_contrast_);
    for (int y = 0; y < edges_.rows; ++y) ScanRow(y, grower);
    return found_;
  }

 private:
  /// Eight marks at a time: one mask selects the bytes with a seed.
  void ScanRow(int y, LineGrower& grower) {
    const uint8_t* row = edges_.ptr<uint8_t>(y);
    const uint64_t seeds = kFlatSeeds | (y % kSeedStride == 0 ? kSteepSeeds : 0);
    for (int x0 = 0; x0 < edges_.cols; x0 += 8) {
      uint64_t eight = 0;
      std::memcpy(&eight, row + x0, static_cast<size_t>(std::min(8, edges_.cols - x0)));
      for (eight &= seeds; eight != 0; eight &= eight - 1) {
        const int x = x0 + std::countr_zero(eight) / 8;
        // Growing may have changed marks in this row.
        if ((row[x] & (kUsedEdge | kTriedEdge)) != 0) continue;
        if (const auto segment = grower.Grow(x, y)) found_.push_back(*segment);
      }
    }
  }

  int threshold_;
  double min_contrast_;
  cv::Mat edges_;
  std::vector<DetectedSegment> found_;
};

}  // namespace

std::unique_ptr<LineDetector> MakeEdgeChainDetector(const LineOptions& options) {
  return std::make_unique<EdgeChainDetector>(options);
}

}  // namespace plslam
