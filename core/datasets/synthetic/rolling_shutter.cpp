#include "core/datasets/synthetic/rolling_shutter.h"

#include <algorithm>

namespace plslam::synthetic {
namespace {

// Of 480: a camera that turns by 20 pixels while it is read moves by a sixth of a pixel from band to band.
constexpr int kBandRows = 4;

}  // namespace

std::vector<float> RenderRollingShutter(const Scene& scene, const std::function<View(double)>& view_at) {
  const View whole = view_at(0.0);
  std::vector<float> radiance;
  radiance.reserve(static_cast<size_t>(whole.width) * whole.height);
  for (int row = 0; row < whole.height; row += kBandRows) {
    const int rows = std::min(kBandRows, whole.height - row);
    View band = view_at((row + 0.5 * (rows - 1)) / whole.height);
    band.height = rows;
    band.cy -= row;
    const std::vector<float> part = RenderRadiance(scene, band);
    radiance.insert(radiance.end(), part.begin(), part.end());
  }
  return radiance;
}

}  // namespace plslam::synthetic
