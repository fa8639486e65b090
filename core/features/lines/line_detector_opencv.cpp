#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_drawing.hpp>

#include "core/features/lines/line_detector.h"

namespace plslam {
namespace {

/// Below this OpenCV's detectors find nothing of use, and some versions read outside the image.
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
    // OpenCV divides (x + 0.5) by the scale; its gradients, half a pixel right of x in the scaled image, belong at
    // (x + 1) / scale - 0.5 of the input.
    return DirectAll(raw, 0.5 / scale_ - 0.5, gradients);
  }

 private:
  double scale_;
  cv::Ptr<cv::LineSegmentDetector> lsd_;
};

class EdLinesDetector : public LineDetector {
 public:
  explicit EdLinesDetector(const LineOptions& options) : drawing_(cv::ximgproc::createEdgeDrawing()) {
    cv::ximgproc::EdgeDrawing::Params params;
    params.EdgeDetectionOperator = cv::ximgproc::EdgeDrawing::SOBEL;
    params.GradientThresholdValue = 36;
    params.AnchorThresholdValue = 8;
    params.MinPathLength = 15;
    params.MinLineLength = static_cast<int>(std::lround(std::clamp(options.min_length_px, 10.0, 40.0)));
    drawing_->setParams(params);
  }

  std::vector<DetectedSegment> Detect(const cv::Mat& image, const Gradients& gradients) override {
    if (std::min(image.rows, image.cols) < kMinSide_px || !HasStructure(gradients)) return {};
    drawing_->detectEdges(image);
    // Without edges, detectLines reads the front of an empty vector.
    if (drawing_->getSegments().empty()) return {};
    std::vector<cv::Vec4f> raw;
    drawing_->detectLines(raw);
    return DirectAll(raw, 0.0, gradients);
  }

 private:
  static bool HasStructure(const Gradients& gradients) {
    double low = 0.0;
    double high = 0.0;
    cv::minMaxIdx(gradients.dx, &low, &high);
    double extreme = std::max(-low, high);
    cv::minMaxIdx(gradients.dy, &low, &high);
    extreme = std::max({extreme, -low, high});
    return extreme >= 2.0 * Gradients::kStepGain;
  }

  cv::Ptr<cv::ximgproc::EdgeDrawing> drawing_;
};

}  // namespace

std::unique_ptr<LineDetector> MakeLsdDetector(const LineOptions& options) {
  return std::make_unique<LsdDetector>(options);
}

std::unique_ptr<LineDetector> MakeEdLinesDetector(const LineOptions& options) {
  return std::make_unique<EdLinesDetector>(options);
}

}  // namespace plslam
