#include "vo_process/tracking/model_error.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

// Segments flatter than this have no depth anyway.
constexpr double kMinSine = 0.1;

}  // namespace

void AddLineModelError(double sigma_px, StereoFeatures& features) {
  for (StereoLine& line : features.lines) {
    line.sigma_px = std::hypot(line.sigma_px, sigma_px);
    const Segment2& segment = line.left.segment;
    const double sine = std::max(std::abs(segment.q.y() - segment.p.y()) / segment.Length(), kMinSine);
    // Along the row both images' errors count, each divided by the sine of the angle to the row.
    const double disparity_sigma_px = M_SQRT2 * sigma_px / sine;
    line.sigma_disparity_p_px = std::hypot(line.sigma_disparity_p_px, disparity_sigma_px);
    line.sigma_disparity_q_px = std::hypot(line.sigma_disparity_q_px, disparity_sigma_px);
  }
}

}  // namespace plslam
