// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/features_in_camera.h"

#include <cmath>

namespace plslam {
namespace {

bool SameProjection(const StereoCamera& a, const StereoCamera& b) { return a.With({}) == b.With({}); }

/// Rounds to single precision, as in messages, so that features that are forwarded keep their bits. Through memory,
/// because GCC 12 omits the rounding of two neighbours when it vectorises them (-ftree-slp-vectorize).
double Rounded(double value) {
  const volatile float rounded = static_cast<float>(value);
  return rounded;
}

/// Maps pixels of one rectified camera to those of another with the same axes.
class PixelChange {
 public:
  PixelChange(const StereoCamera& from, const StereoCamera& to)
      : from_{from.cx_px, from.cy_px},
        to_{to.cx_px, to.cy_px},
        scale_(to.f_px / from.f_px),
        disparity_scale_(to.FocalBaseline() / from.FocalBaseline()) {}

  double scale() const { return scale_; }
  Eigen::Vector2d Pixel(const Eigen::Vector2d& px) const {
    const Eigen::Vector2d changed = (px - from_) * scale_ + to_;
    return {Rounded(changed.x()), Rounded(changed.y())};
  }
  double Length(double px) const { return Rounded(px * scale_); }
  /// For disparities and their standard deviations. Negative (unknown) values stay negative.
  double Disparity(double px) const { return Rounded(px * disparity_scale_); }

  TakenImage Image(const TakenImage& image) const {
    const Eigen::Vector2d least = Pixel(Eigen::Vector2d(image.left_px, image.top_px));
    const Eigen::Vector2d most =
        Pixel(Eigen::Vector2d(image.left_px + image.width_px - 1, image.top_px + image.height_px - 1));
    const auto whole = [](double px) { return static_cast<int>(std::lround(px)); };
    const int left_px = whole(least.x()), top_px = whole(least.y());
    return {left_px, top_px, whole(most.x()) - left_px + 1, whole(most.y()) - top_px + 1, image.f_px};
  }

 private:
  Eigen::Vector2d from_;
  Eigen::Vector2d to_;
  double scale_;
  double disparity_scale_;
};

void Change(const PixelChange& change, StereoPoint& point) {
  point.left.px = change.Pixel(point.left.px);
  point.left.scale *= change.scale();
  point.disparity_px = change.Disparity(point.disparity_px);
  point.sigma_px = change.Length(point.sigma_px);
  point.sigma_disparity_px = change.Disparity(point.sigma_disparity_px);
  point.row_offset_px = change.Length(point.row_offset_px);
  point.sigma_row_px = change.Length(point.sigma_row_px);
}

void Change(const PixelChange& change, StereoLine& line) {
  line.left.segment = {change.Pixel(line.left.segment.p), change.Pixel(line.left.segment.q)};
  line.disparity_p_px = change.Disparity(line.disparity_p_px);
  line.disparity_q_px = change.Disparity(line.disparity_q_px);
  line.sigma_px = change.Length(line.sigma_px);
  line.sigma_disparity_p_px = change.Disparity(line.sigma_disparity_p_px);
  line.sigma_disparity_q_px = change.Disparity(line.sigma_disparity_q_px);
}

}  // namespace

StereoFeatures FeaturesInCamera(const StereoCamera& to, StereoFeatures features, const StereoCamera& from) {
  TakenImage image = from.image();
  if (!SameProjection(from, to)) {
    const PixelChange change(from, to);
    for (StereoPoint& point : features.points) Change(change, point);
    for (StereoLine& line : features.lines) Change(change, line);
    image = change.Image(image);
  }
  features.image = image == to.image() ? std::nullopt : std::optional(image);
  return features;
}

bool AreComparable(const StereoCamera& to, const StereoCamera& from) {
  const auto alike = [](double a, double b) { return a <= kMostUnlike * b && b <= kMostUnlike * a; };
  return alike(to.f_px, from.f_px) && alike(to.baseline_m, from.baseline_m);
}

}  // namespace plslam
