// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/geometry/hypot.h"
#include "core/motion/robust.h"

namespace plslam::dense {
namespace {

constexpr double kDisparityUnits = 16.0;  // of OpenCV's matcher
// Margin beyond the largest disparity of the features, since surfaces nearer than all of them are seen, too.
constexpr double kDisparityMargin = 1.3;
constexpr double kMoreDisparities = 16.0;
constexpr int kMostDisparities = 256;
constexpr int kBlock_px = 5;
constexpr double kSmooth_px = 1.5;
constexpr double kLeastDisparity_px = 0.5;
// Disparities of neighbours that differ by more belong to different surfaces, or are errors.
constexpr float kJump_px = 1.0F;
// Mean gradient along the row, in grey levels a pixel, below which a match follows noise and its neighbours: a multiple
// of the noise, within bounds.
constexpr int kTextureWindow_px = 11;
constexpr double kTextureToNoise = 1.4;
constexpr double kLeastTexture = 0.1;
constexpr int kRefinement_px = 9;
// Independent pixels of a window: interpolation correlates neighbours.
constexpr float kIndependent = 40.0F;
constexpr float kFloor_px = 0.05F;  // error of the model: surfaces are not plane
// The matcher's disparity as a prior: variance of the images' noise over that of the prior, for a window.
constexpr float kPrior = 2.5F;
constexpr float kLargestStep_px = 0.5F;
// Lines with a larger standard deviation of their middle disparity do not show the error of the matcher.
constexpr double kLineSigma_px = 0.25;
// Fewer compared features tell nothing about the error.
constexpr size_t kLeastCompared = 20;
constexpr double kUnknownScale = 2.0;
// Noise of a structured-light camera: sigma_z = 0.0028 z^2 (Khoshelham 2012), as in vo_process/stereo/depth_points.h.
constexpr double kSensorSigma_per_m = 0.0028;
constexpr float kSensorJump = 0.03F;  // of the depth
// Windows whose means give the gradient of the disparities, and their least known share.
constexpr int kNormalWindow_px = 9;
constexpr float kMostlyKnown = 0.3F;
constexpr float kUnknownIncidence = 0.7F;
constexpr float kLeastIncidence = 0.35F;
// Farthest known pixel that bounds a blank one, as a share of the width, and the longest gap of other unknown pixels on
// the way: matches fail at borders of surfaces, too.
constexpr double kBoundReach = 1.0 / 6.0;
constexpr int kBoundGap_px = 8;
constexpr float kBoundSigmas = 2.5F;

int DisparityRange(const StereoFeatures& features, int width_px) {
  double largest_px = 0.0;
  for (const StereoPoint& point : features.points) largest_px = std::max(largest_px, point.disparity_px);
  const double range_px = std::min(kDisparityMargin * largest_px + kMoreDisparities, 0.5 * width_px);
  return std::clamp(16 * static_cast<int>(std::ceil(range_px / 16.0)), 16, kMostDisparities);
}

/// Standard deviation of the noise of an image, from its difference to a smooth one.
double NoiseOf(const cv::Mat& image, const cv::Mat& smooth) {
  std::vector<double> differences;
  constexpr int kStep = 7;
  for (int y = 0; y < image.rows; y += kStep) {
    for (int x = 0; x < image.cols; x += kStep) {
      differences.push_back(std::abs(image.at<uint8_t>(y, x) - smooth.at<float>(y, x)));
    }
  }
  return kSigmaOfMedian * Median(differences);
}

/// Whether the mean gradient along the row in a window is more than that of noise.
cv::Mat HasTexture(const cv::Mat& image) {
  cv::Mat smooth, gradient, texture;
  image.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, kSmooth_px);
  cv::Sobel(smooth, gradient, CV_32F, 1, 0, 1, 0.5);
  cv::blur(cv::abs(gradient), texture, {kTextureWindow_px, kTextureWindow_px});
  // Mean absolute value of smoothed noise, differentiated.
  const double noise = NoiseOf(image, smooth) * 0.8 / (5.0 * kSmooth_px * kSmooth_px);
  return texture > std::max(kTextureToNoise * noise, kLeastTexture);
}

/// Sets values to 0 at which a neighbour is unknown or differs by more than `jump + jump_share * value`.
void RemoveBorders(cv::Mat& values, float jump, float jump_share) {
  cv::Mat least, most;
  const cv::Mat window = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  cv::erode(values, least, window);
  cv::dilate(values, most, window);
  for (int y = 0; y < values.rows; ++y) {
    auto* const row = values.ptr<float>(y);
    for (int x = 0; x < values.cols; ++x) {
      const float low = least.at<float>(y, x);
      const float high = most.at<float>(y, x);
      if (low <= 0.0F || high - low > 2.0F * (jump + jump_share * high)) row[x] = 0.0F;
    }
  }
}

/// Improves disparities (0: unknown) by least squares along the row: Lucas and Kanade's step in each window, with the
/// right image warped by the current disparities, and without the windows' mean difference. The matcher interpolates
/// costs of whole pixels, whose error is several times as large. Returns the standard deviations, from the residuals in
/// each window. Sums are of the known pixels of a window.
cv::Mat Refine(const cv::Mat& left, const cv::Mat& right, cv::Mat& disparity) {
  const cv::Size window(kRefinement_px, kRefinement_px);
  cv::Mat left32, right32;
  left.convertTo(left32, CV_32F);
  right.convertTo(right32, CV_32F);
  cv::Mat column(disparity.size(), CV_32F), row(disparity.size(), CV_32F);
  for (int y = 0; y < disparity.rows; ++y) {
    const auto* const d = disparity.ptr<float>(y);
    auto* const x_right = column.ptr<float>(y);
    row.row(y).setTo(static_cast<float>(y));
    for (int x = 0; x < disparity.cols; ++x) x_right[x] = static_cast<float>(x) - d[x];
  }
  const cv::Mat unknown = disparity <= 0.0F;
  cv::Mat warped, gradient, mean_gradient, mean_difference, square, product, residual, known;
  cv::remap(right32, warped, column, row, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::Sobel(left32 + warped, gradient, CV_32F, 1, 0, 1, 0.25);
  cv::Mat difference = left32 - warped;
  gradient.setTo(0.0, unknown);
  difference.setTo(0.0, unknown);
  cv::Mat(disparity > 0.0F).convertTo(known, CV_32F, 1.0 / 255.0);
  cv::blur(known, known, window);
  cv::blur(gradient, mean_gradient, window);
  cv::blur(difference, mean_difference, window);
  cv::blur(gradient.mul(gradient), square, window);
  cv::blur(gradient.mul(difference), product, window);
  cv::blur(difference.mul(difference), residual, window);
  cv::Mat sigma(disparity.size(), CV_32F, cv::Scalar(0.0));
  for (int y = 0; y < disparity.rows; ++y) {
    auto* const d = disparity.ptr<float>(y);
    for (int x = 0; x < disparity.cols; ++x) {
      if (d[x] <= 0.0F) continue;
      const float g = mean_gradient.at<float>(y, x);
      const float e = mean_difference.at<float>(y, x);
      const float share = known.at<float>(y, x);
      const float information = square.at<float>(y, x) - g * g / share + kPrior;
      const float step = (product.at<float>(y, x) - g * e / share) / information;
      const float squares = residual.at<float>(y, x) - e * e / share - step * step * information;
      const float variance = std::max(squares / share, 0.1F);
      d[x] = std::max(0.01F, d[x] - std::clamp(step, -kLargestStep_px, kLargestStep_px));
      sigma.at<float>(y, x) = std::sqrt(kFloor_px * kFloor_px + variance / (kIndependent * information));
    }
  }
  return sigma;
}

/// A matched disparity minus that of a feature, and the standard deviation of the difference.
struct Difference {
  double px = 0.0;
  double sigma_px = 0.0;
};

/// Compares with the keyframe's points and lines, which have smaller errors and include self-calibration. Only pixels in
/// use have a disparity.
void Compare(const cv::Mat& disparity, const cv::Mat& sigma_px, const cv::Mat& in_use, const StereoFeatures& features,
             DepthImage& depth) {
  std::vector<Difference> differences;
  const auto pixel = [](const Eigen::Vector2d& px) {
    return cv::Point(static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y())));
  };
  const cv::Rect image({}, disparity.size());
  int n_close = 0;
  for (const StereoPoint& point : features.points) {
    const cv::Point at = pixel(point.left.px);
    if (!point.HasDepth() || !image.contains(at)) continue;
    if (!in_use.empty() && in_use.at<uint8_t>(at) == 0) continue;
    ++depth.n_compared;
    const float matched_px = disparity.at<float>(at);
    if (matched_px <= 0.0F) continue;
    const double difference = matched_px - point.disparity_px;
    if (std::abs(difference) < 1.0) ++n_close;
    differences.push_back({difference, sigma_px.at<float>(at)});
  }
  if (depth.n_compared > 0) depth.agreement = static_cast<double>(n_close) / depth.n_compared;
  for (const StereoLine& line : features.lines) {
    const cv::Point at = pixel(0.5 * (line.left.segment.p + line.left.segment.q));
    if (!line.HasDepth() || !image.contains(at)) continue;
    const double sigma = 0.5 * Hypot(line.sigma_disparity_p_px, line.sigma_disparity_q_px);
    const float matched_px = disparity.at<float>(at);
    if (matched_px <= 0.0F || sigma > kLineSigma_px) continue;
    ++depth.n_lines_compared;
    differences.push_back({matched_px - line.MiddleDisparity_px(), Hypot(sigma_px.at<float>(at), sigma)});
  }
  depth.sigma_scale = kUnknownScale;
  if (differences.size() < kLeastCompared) return;
  std::vector<double> values;
  values.reserve(differences.size());
  for (const Difference& difference : differences) values.push_back(difference.px);
  depth.offset_px = Median(values);
  values.clear();
  for (const Difference& difference : differences)
    values.push_back(std::abs(difference.px - depth.offset_px) / difference.sigma_px);
  depth.sigma_scale = std::max(1.0, kSigmaOfMedian * Median(values));
}

/// A walk over pixels in one direction, which carries the depth of the last known one into blank pixels.
class BoundWalk {
 public:
  explicit BoundWalk(int reach_px) : reach_px_(reach_px) {}

  /// Returns the bound at the next pixel; 0: none.
  float Step(float z_m, float sigma_m, bool is_blank, bool in_use) {
    if (z_m > 0.0F) {
      *this = BoundWalk(reach_px_);
      bound_m_ = z_m - kBoundSigmas * sigma_m;
      return 0.0F;
    }
    gap_px_ = is_blank ? 0 : gap_px_ + 1;
    if (++distance_px_ > reach_px_ || gap_px_ > kBoundGap_px || !in_use) bound_m_ = 0.0F;
    return is_blank ? bound_m_ : 0.0F;
  }

 private:
  int reach_px_;
  int distance_px_ = 0;
  int gap_px_ = 0;
  float bound_m_ = 0.0F;
};

/// Lower bounds in blank pixels; `in_use` may be empty.
cv::Mat LowerBounds(const DepthImage& depth, const cv::Mat& has_texture, const cv::Mat& in_use) {
  const cv::Size size = depth.z_m.size();
  cv::Mat least(size, CV_32F, cv::Scalar(std::numeric_limits<float>::max()));
  const auto reach_px = static_cast<int>(kBoundReach * size.width);
  const auto visit = [&](BoundWalk& walk, int y, int x) {
    const float bound =
        walk.Step(depth.z_m.at<float>(y, x), depth.sigma_m.at<float>(y, x), has_texture.at<uint8_t>(y, x) == 0,
                  in_use.empty() || in_use.at<uint8_t>(y, x) != 0);
    float& at = least.at<float>(y, x);
    at = std::min(at, std::max(bound, 0.0F));
  };
  for (int y = 0; y < size.height; ++y) {
    BoundWalk right(reach_px), left(reach_px);
    for (int x = 0; x < size.width; ++x) visit(right, y, x);
    for (int x = size.width - 1; x >= 0; --x) visit(left, y, x);
  }
  // All columns together, in the order of the memory.
  std::vector<BoundWalk> down(static_cast<size_t>(size.width), BoundWalk(reach_px));
  std::vector<BoundWalk> up = down;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) visit(down[static_cast<size_t>(x)], y, x);
  }
  for (int y = size.height - 1; y >= 0; --y) {
    for (int x = 0; x < size.width; ++x) visit(up[static_cast<size_t>(x)], y, x);
  }
  return least;
}

/// Cosine of the angle between a pixel's ray and the normal of its surface, from the gradient of the disparities 1/z
/// around it: a plane has a linear one, n . p = 1 with n = (a f, b f, c).
class Incidence {
 public:
  Incidence(const cv::Mat& z_m, const StereoCamera& camera)
      : camera_(camera), z_m_(z_m), inverse_(z_m.size(), CV_32F), known_(z_m.size(), CV_32F) {
    for (int y = 0; y < z_m.rows; ++y) {
      for (int x = 0; x < z_m.cols; ++x) {
        const float z = z_m.at<float>(y, x);
        inverse_.at<float>(y, x) = z > 0.0F ? 1.0F / z : 0.0F;
        known_.at<float>(y, x) = z > 0.0F ? 1.0F : 0.0F;
      }
    }
    const cv::Size window(kNormalWindow_px, kNormalWindow_px);
    cv::blur(inverse_, inverse_, window);
    cv::blur(known_, known_, window);
  }

  /// At a pixel with a depth; `kUnknownIncidence` without neighbours.
  float At(int y, int x) const {
    constexpr int kStep = kNormalWindow_px / 2 + 1;
    if (y < kStep || x < kStep || y >= z_m_.rows - kStep || x >= z_m_.cols - kStep) return kUnknownIncidence;
    const bool all = IsKnown(y, x - kStep) && IsKnown(y, x + kStep) && IsKnown(y - kStep, x) && IsKnown(y + kStep, x);
    if (!all) return kUnknownIncidence;
    const double z = z_m_.at<float>(y, x);
    const double a = (Mean(y, x + kStep) - Mean(y, x - kStep)) / (2.0 * kStep);
    const double b = (Mean(y + kStep, x) - Mean(y - kStep, x)) / (2.0 * kStep);
    const double u = x - camera_.cx_px, v = y - camera_.cy_px;
    const Eigen::Vector3d normal(a * camera_.f_px, b * camera_.f_px, 1.0 / z - a * u - b * v);
    const double length = z * std::sqrt(1.0 + (u * u + v * v) / (camera_.f_px * camera_.f_px));
    return std::clamp(static_cast<float>(1.0 / (normal.norm() * length)), kLeastIncidence, 1.0F);
  }

 private:
  bool IsKnown(int y, int x) const { return known_.at<float>(y, x) > kMostlyKnown; }
  float Mean(int y, int x) const { return inverse_.at<float>(y, x) / known_.at<float>(y, x); }

  const StereoCamera& camera_;
  const cv::Mat& z_m_;
  cv::Mat inverse_, known_;  // means of a window: of 1/z, and of the known share
};

uint64_t KeyOf(const Eigen::Vector3d& p, double voxel_m) {
  uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    key = key << 21 | (static_cast<uint64_t>(static_cast<int64_t>(std::lround(p[i] / voxel_m))) & 0x1FFFFF);
  }
  return key;
}

}  // namespace

DepthImage MatchPair(const cv::Mat& left, const cv::Mat& measured_right, const cv::Mat& in_use,
                     const StereoCamera& camera, const StereoFeatures& features) {
  DepthImage depth;
  depth.rows = EstimateRows(features, camera);
  const cv::Mat right = StraightenRows(measured_right, depth.rows, camera);
  const int range_px = DisparityRange(features, left.cols);
  constexpr int kArea = kBlock_px * kBlock_px;
  const cv::Ptr<cv::StereoSGBM> matcher = cv::StereoSGBM::create(0, range_px, kBlock_px, 8 * kArea, 32 * kArea, 1, 31,
                                                                 10, 100, 2, cv::StereoSGBM::MODE_SGBM_3WAY);
  // Without the border, the matcher would leave out as many columns as there are disparities.
  cv::Mat wide_left, wide_right, matched;
  cv::Mat smooth_left, smooth_right;
  cv::GaussianBlur(left, smooth_left, {}, kSmooth_px);
  cv::GaussianBlur(right, smooth_right, {}, kSmooth_px);
  cv::copyMakeBorder(smooth_left, wide_left, 0, 0, range_px, 0, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(smooth_right, wide_right, 0, 0, range_px, 0, cv::BORDER_REPLICATE);
  matcher->compute(wide_left, wide_right, matched);
  cv::Mat disparity;
  matched.colRange(range_px, matched.cols).convertTo(disparity, CV_32F, 1.0 / kDisparityUnits);
  cv::max(disparity, 0.0, disparity);
  const cv::Mat has_texture = HasTexture(left);
  disparity.setTo(0.0, ~has_texture);
  if (!in_use.empty()) disparity.setTo(0.0, in_use == 0);
  // A pixel whose match is outside the right image was matched with the border.
  for (int y = 0; y < disparity.rows; ++y) {
    auto* const row = disparity.ptr<float>(y);
    for (int x = 0; x < std::min(range_px, disparity.cols); ++x) {
      if (row[x] > static_cast<float>(x)) row[x] = 0.0F;
    }
  }
  RemoveBorders(disparity, kJump_px, 0.0F);
  const cv::Mat sigma_px = Refine(left, right, disparity);
  Compare(disparity, sigma_px, in_use, features, depth);
  depth.z_m = cv::Mat::zeros(disparity.size(), CV_32F);
  depth.sigma_m = cv::Mat::zeros(disparity.size(), CV_32F);
  for (int y = 0; y < disparity.rows; ++y) {
    const auto* const from = disparity.ptr<float>(y);
    for (int x = 0; x < disparity.cols; ++x) {
      const double d = from[x] - depth.offset_px;
      if (from[x] <= 0.0F || d < kLeastDisparity_px) continue;
      const double z = camera.Depth(d);
      depth.z_m.at<float>(y, x) = static_cast<float>(z);
      depth.sigma_m.at<float>(y, x) = static_cast<float>(depth.sigma_scale * sigma_px.at<float>(y, x) * z / d);
    }
  }
  depth.at_least_m = LowerBounds(depth, has_texture, in_use);
  return depth;
}

DepthImage FromSensor(const cv::Mat& depth16, double units_per_m) {
  DepthImage depth;
  depth16.convertTo(depth.z_m, CV_32F, 1.0 / units_per_m);
  RemoveBorders(depth.z_m, 0.0F, kSensorJump);
  depth.sigma_m = kSensorSigma_per_m * depth.z_m.mul(depth.z_m);
  return depth;
}

std::vector<DepthRay> MakeRays(const DepthImage& depth, const cv::Mat& grey, const StereoCamera& camera,
                               const SE3& T_s_c, double voxel_m, double range_m) {
  const double nearest_m = camera.MinDepth();
  struct Sum {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    double weight = 0.0;
    double grey = 0.0;
    double incidence = 0.0;
    float most = 0.0F;
  };
  const Incidence incidence(depth.z_m, camera);
  std::vector<Sum> sums;
  std::unordered_map<uint64_t, size_t> index_of;
  const Eigen::Matrix3d R_s_c = T_s_c.R();
  uint64_t last_key = std::numeric_limits<uint64_t>::max();
  size_t last = 0;
  for (int y = 0; y < depth.z_m.rows; ++y) {
    const auto* const row = depth.z_m.ptr<float>(y);
    const auto* const sigma = depth.sigma_m.ptr<float>(y);
    for (int x = 0; x < depth.z_m.cols; ++x) {
      const double z = row[x];
      if (z < nearest_m || z > range_m || sigma[x] > kSigmasInVoxels * voxel_m) continue;
      const Eigen::Vector3d p_c((x - camera.cx_px) / camera.f_px * z, (y - camera.cy_px) / camera.f_px * z, z);
      const Eigen::Vector3d p = R_s_c * p_c + T_s_c.translation();
      const uint64_t key = KeyOf(p, voxel_m);
      if (key != last_key) {
        last_key = key;
        last = index_of.try_emplace(key, sums.size()).first->second;
        if (last == sums.size()) sums.emplace_back();
      }
      const double in_voxels = 2.0 * sigma[x] / voxel_m;
      const double weight = 1.0 / (1.0 + in_voxels * in_voxels);
      Sum& sum = sums[last];
      sum.p += weight * p;
      sum.weight += weight;
      sum.grey += weight * grey.at<uint8_t>(y, x);
      sum.incidence += weight * incidence.At(y, x);
      sum.most = std::max(sum.most, static_cast<float>(weight));
    }
  }
  std::vector<DepthRay> rays;
  rays.reserve(sums.size());
  for (const Sum& sum : sums) {
    rays.push_back({sum.p / sum.weight, sum.most, static_cast<float>(sum.grey / sum.weight),
                    static_cast<float>(sum.incidence / sum.weight)});
  }
  return rays;
}

std::vector<Eigen::Vector3d> MakeBoundEnds(const DepthImage& depth, const StereoCamera& camera, const SE3& T_s_c,
                                           double voxel_m, double range_m) {
  const double nearest_m = camera.MinDepth();
  std::vector<Eigen::Vector3d> ends;
  std::unordered_set<uint64_t> cubes;
  for (int y = 0; y < depth.at_least_m.rows; ++y) {
    for (int x = 0; x < depth.at_least_m.cols; ++x) {
      const double z = std::min<double>(depth.at_least_m.at<float>(y, x), range_m);
      if (z < nearest_m) continue;
      const Eigen::Vector3d p_c((x - camera.cx_px) / camera.f_px * z, (y - camera.cy_px) / camera.f_px * z, z);
      const Eigen::Vector3d p = T_s_c * p_c;
      if (cubes.insert(KeyOf(p, voxel_m)).second) ends.push_back(p);
    }
  }
  return ends;
}

}  // namespace plslam::dense
