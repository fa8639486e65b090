#include "vo_process/stereo/halved_pair.h"

#include "core/features/image/halved_image.h"

namespace plslam {

HalvedPair::HalvedPair(const cv::Mat& left, const cv::Mat& right) {
  levels_.push_back({left, right, 1.0});
  while (levels_.size() < kHalvedLevels) {
    const Level& last = levels_.back();
    Level next{Halved(last.left), Halved(last.right), 2.0 * last.size_px};
    if (next.left.empty() || next.right.empty()) break;
    levels_.push_back(next);
  }
}

const HalvedPair::Level& HalvedPair::LevelFor(double scale) const { return NearestLevel(levels_, scale); }

}  // namespace plslam
