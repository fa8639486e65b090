#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "core/features/line_detector.h"
#include "core/features/line_edge_map.h"
#include "core/features/line_grower.h"

namespace plslam {
namespace {

/// Seeds stand on every fourth row (steep edges) or column (flat ones): any segment worth having crosses several.
constexpr int kSeedStride = 4;

class EdgeChainDetector : public LineDetector {
 public:
  explicit EdgeChainDetector(const LineOptions& options)
      // A pixel of a slanted or noisy edge shows less than the contrast of its segment.
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
  void ScanRow(int y, LineGrower& grower) {
    const uint8_t* row = edges_.ptr<uint8_t>(y);
    for (int x0 = 0; x0 < edges_.cols; x0 += 8) {
      const int count = std::min(8, edges_.cols - x0);
      uint64_t eight = 0;
      std::memcpy(&eight, row + x0, static_cast<size_t>(count));
      if (eight == 0) continue;
      for (int x = x0; x < x0 + count; ++x) TrySeed(x, y, row[x], grower);
    }
  }

  void TrySeed(int x, int y, uint8_t mark, LineGrower& grower) {
    const bool is_seed = (mark == kSteepEdge && y % kSeedStride == 0) || (mark == kFlatEdge && x % kSeedStride == 0);
    if (!is_seed) return;
    if (const auto segment = grower.Grow(x, y)) found_.push_back(*segment);
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
