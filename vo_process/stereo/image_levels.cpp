#include "vo_process/stereo/image_levels.h"

#include "core/features/image/halved_image.h"

namespace plslam {

ImageLevels::ImageLevels(const cv::Mat& image) {
  if (image.empty()) return;
  levels_.push_back({image, 1.0});
  while (levels_.size() < kHalvedLevels) {
    const Level& last = levels_.back();
    Level next{Halved(last.image), 2.0 * last.size_px};
    if (next.image.empty()) break;
    levels_.push_back(next);
  }
}

const ImageLevels::Level& ImageLevels::LevelFor(double scale) const { return NearestLevel(levels_, scale); }

}  // namespace plslam
