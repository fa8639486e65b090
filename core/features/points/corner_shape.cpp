#include "core/features/points/corner_shape.h"

#include <cmath>
#include <cstdint>

namespace plslam {
namespace {

constexpr int kRadius_px = 3;

}  // namespace

double CornerRatio(const cv::Mat& image, int x, int y) {
  const auto step = static_cast<std::ptrdiff_t>(image.step);
  int64_t xx = 0;
  int64_t xy = 0;
  int64_t yy = 0;
  for (int row = y - kRadius_px; row <= y + kRadius_px; ++row) {
    const uint8_t* p = image.ptr<uint8_t>(row) + x - kRadius_px;
    for (int i = 0; i <= 2 * kRadius_px; ++i, ++p) {
      const int gx = p[1] - p[-1];
      const int gy = p[step] - p[-step];
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  const auto trace = static_cast<double>(xx + yy);
  const auto difference = static_cast<double>(xx - yy);
  const double spread = std::sqrt(difference * difference + 4.0 * static_cast<double>(xy) * static_cast<double>(xy));
  return trace > 0.0 ? (trace - spread) / (trace + spread) : 0.0;
}

}  // namespace plslam
