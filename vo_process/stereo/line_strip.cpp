#include "vo_process/stereo/line_strip.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace plslam {
namespace {

constexpr int kPlaces = 16;
constexpr int kReach = 6;
/// Pixels of the other side that belong to either strip: the edge itself.
constexpr int kOverEdge = 1;
constexpr int kColumns = 2 * kReach + 1;

using Strip = std::array<std::array<double, kColumns>, kPlaces>;

/// Grey values around (u, v) along the row nearest to v; false outside the image.
bool SampleRow(const cv::Mat& image, double u, double v, std::array<double, kColumns>& out) {
  const int y = static_cast<int>(std::lround(v));
  const double floor_u = std::floor(u);
  const int x = static_cast<int>(floor_u);
  if (y < 0 || y >= image.rows || x - kReach < 0 || x + kReach + 1 >= image.cols) return false;
  const uint8_t* row = image.ptr<uint8_t>(y) + x - kReach;
  const double w = u - floor_u;
  for (size_t i = 0; i < kColumns; ++i) out[i] = (1.0 - w) * row[i] + w * row[i + 1];
  return true;
}

/// Zero-mean normalised correlation of columns [first, last] of rows [0, count).
double Correlation(const Strip& a, const Strip& b, size_t count, size_t first, size_t last) {
  double n = 0, sa = 0, sb = 0, aa = 0, bb = 0, ab = 0;
  for (size_t r = 0; r < count; ++r) {
    for (size_t c = first; c <= last; ++c) {
      n += 1.0;
      sa += a[r][c];
      sb += b[r][c];
      aa += a[r][c] * a[r][c];
      bb += b[r][c] * b[r][c];
      ab += a[r][c] * b[r][c];
    }
  }
  const double va = n * aa - sa * sa;
  const double vb = n * bb - sb * sb;
  return va > 0.0 && vb > 0.0 ? (n * ab - sa * sb) / std::sqrt(va * vb) : 0.0;
}

}  // namespace

double StripSimilarity(const cv::Mat& left_image, const cv::Mat& right_image, const Segment2& left,
                       double disparity_p_px, double disparity_q_px, const RowField& rows) {
  Strip a;
  Strip b;
  size_t count = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double t = (i + 0.5) / kPlaces;
    const Eigen::Vector2d at = left.p + t * (left.q - left.p);
    const double right_u = at.x() - disparity_p_px - t * (disparity_q_px - disparity_p_px);
    const double right_v = at.y() + rows.Offset_px({right_u, at.y()});
    if (SampleRow(left_image, at.x(), at.y(), a[count]) && SampleRow(right_image, right_u, right_v, b[count])) {
      ++count;
    }
  }
  if (count < kPlaces / 4) return 0.0;
  return std::max(Correlation(a, b, count, 0, kReach + kOverEdge),
                  Correlation(a, b, count, kReach - kOverEdge, kColumns - 1));
}

}  // namespace plslam
