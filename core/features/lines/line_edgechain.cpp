#include <algorithm>
#include <bit>
#include <cstring>

#include "core/features/lines/line_detector.h"
#include "core/features/lines/line_edge_map.h"
#include "core/features/lines/line_grower.h"

namespace plslam {
namespace {

/// Seeds stand on every fourth row (steep edges) or column (flat ones): any segment worth having crosses several.
constexpr int kSeedStride = 4;
constexpr uint64_t kSteepSeeds = 0x0101010101010101 * kSteepEdge;
constexpr uint64_t kFlatSeeds = 0x0000000100000001 * kFlatEdge;
static_assert(std::endian::native == std::endian::little, "the first of eight marks is the lowest byte");

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
  /// Eight marks at a time: the bytes that hold a seed are picked by one mask.
  void ScanRow(int y, LineGrower& grower) {
    const uint8_t* row = edges_.ptr<uint8_t>(y);
    const uint64_t seeds = kFlatSeeds | (y % kSeedStride == 0 ? kSteepSeeds : 0);
    for (int x0 = 0; x0 < edges_.cols; x0 += 8) {
      uint64_t eight = 0;
      std::memcpy(&eight, row + x0, static_cast<size_t>(std::min(8, edges_.cols - x0)));
      for (eight &= seeds; eight != 0; eight &= eight - 1) {
        const int x = x0 + std::countr_zero(eight) / 8;
        // Growing changes marks on the way.
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
