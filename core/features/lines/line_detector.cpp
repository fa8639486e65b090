#include "core/features/lines/line_detector.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace plslam {

std::unique_ptr<LineDetector> MakeLineDetector(const LineOptions& options) {
  if (options.detector == "edgechain") return MakeEdgeChainDetector(options);
  if (options.detector == "edlines") return MakeEdLinesDetector(options);
  if (options.detector == "lsd") return MakeLsdDetector(options);
  throw std::invalid_argument("unknown line detector '" + options.detector + "': edgechain, edlines or lsd");
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

}  // namespace plslam
