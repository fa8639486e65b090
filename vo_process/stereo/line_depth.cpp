// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/features/lines/line_sigma.h"
#include "vo_process/stereo/line_stereo.h"

namespace plslam::vo {
namespace {

constexpr int kMinDepthSamples = 8;
constexpr int kMaxDepthSamples = 64;
constexpr double kMinKnownShare = 0.5;
constexpr double kMinInlierShare = 0.7;
/// Largest gap between inliers, as a share of the segment.
constexpr double kMaxHole = 0.25;

/// Inverse depth at a position along a segment (0 at p, 1 at q).
struct DepthSample {
  double t;
  double inverse_m;
};

/// Noise of an inverse depth: the sigma of a depth over its square (`StereoOptions::depth_noise_per_m`), the same at
/// all depths.
struct DepthSensor {
  double units_per_m;
  double inverse_noise;

  double Tolerance(double inverse_m) const { return 3.0 * inverse_noise + 0.02 * inverse_m; }
};

/// Returns the nearest surface within a pixel across the segment: object edges belong to the object in front.
std::optional<double> InverseDepthNear(const cv::Mat& depth, const Eigen::Vector2d& at, const Eigen::Vector2d& normal,
                                       const DepthSensor& sensor) {
  double largest = 0.0;
  std::array<double, 3> known{};
  size_t count = 0;
  for (int k = -1; k <= 1; ++k) {
    const Eigen::Vector2d place = at + k * normal;
    const int x = static_cast<int>(std::lround(place.x()));
    const int y = static_cast<int>(std::lround(place.y()));
    if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) continue;
    const uint16_t raw = depth.at<uint16_t>(y, x);
    if (raw == 0) continue;
    known[count] = sensor.units_per_m / raw;
    largest = std::max(largest, known[count]);
    ++count;
  }
  if (count == 0) return std::nullopt;
  // On one surface the mean is less noisy than the nearest depth.
  double sum = 0.0;
  int close = 0;
  for (size_t i = 0; i < count; ++i) {
    if (largest - known[i] > 0.05 * largest + 4.0 * sensor.inverse_noise) continue;
    sum += known[i];
    ++close;
  }
  return sum / close;
}

std::vector<DepthSample> SampleAlong(const cv::Mat& depth, const Segment2& s, int count, const DepthSensor& sensor) {
  const Eigen::Vector2d step = s.q - s.p;
  const Eigen::Vector2d normal = Eigen::Vector2d(-step.y(), step.x()).normalized();
  std::vector<DepthSample> samples;
  for (int i = 0; i < count; ++i) {
    const double t = (i + 0.5) / count;
    const auto inverse = InverseDepthNear(depth, s.p + t * step, normal, sensor);
    if (inverse) samples.push_back({t, *inverse});
  }
  return samples;
}

/// Inverse depth along the line: a + b t.
struct DepthLine {
  double a = 0.0;
  double b = 0.0;
  double At(double t) const { return a + b * t; }
};

int CountInliers(const std::vector<DepthSample>& samples, const DepthLine& line, const DepthSensor& sensor) {
  int count = 0;
  for (const DepthSample& s : samples)
    count += std::abs(s.inverse_m - line.At(s.t)) <= sensor.Tolerance(s.inverse_m) ? 1 : 0;
  return count;
}

/// Returns the line through two samples with most inliers; tries all pairs of up to sixteen samples.
DepthLine MostAgreed(const std::vector<DepthSample>& samples, const DepthSensor& sensor) {
  DepthLine best{samples.front().inverse_m, 0.0};
  int most = CountInliers(samples, best, sensor);
  const size_t stride = std::max<size_t>(1, samples.size() / 16);
  for (size_t i = 0; i < samples.size(); i += stride) {
    for (size_t j = i + stride; j < samples.size(); j += stride) {
      const double b = (samples[j].inverse_m - samples[i].inverse_m) / (samples[j].t - samples[i].t);
      const DepthLine line{samples[i].inverse_m - b * samples[i].t, b};
      const int count = CountInliers(samples, line, sensor);
      if (count > most) {
        most = count;
        best = line;
      }
    }
  }
  return best;
}

struct FittedDepth {
  DepthLine line;
  /// Standard deviations at t = 0 and t = 1.
  double sigma_p = 0.0;
  double sigma_q = 0.0;
};

std::optional<FittedDepth> LeastSquares(const std::vector<DepthSample>& inliers, double inverse_noise) {
  const double n = static_cast<double>(inliers.size());
  double t = 0, y = 0, tt = 0, ty = 0;
  for (const DepthSample& s : inliers) {
    t += s.t;
    y += s.inverse_m;
    tt += s.t * s.t;
    ty += s.t * s.inverse_m;
  }
  const double spread = tt - t * t / n;
  if (!(spread > 0.0)) return std::nullopt;
  FittedDepth fit;
  fit.line.b = (ty - t * y / n) / spread;
  fit.line.a = (y - fit.line.b * t) / n;
  double squares = 0.0;
  for (const DepthSample& s : inliers) squares += (s.inverse_m - fit.line.At(s.t)) * (s.inverse_m - fit.line.At(s.t));
  const double noise = std::max(std::sqrt(squares / (n - 2.0)), inverse_noise);
  const auto sigma = [&](double place) {
    return noise * std::sqrt(1.0 / n + (place - t / n) * (place - t / n) / spread);
  };
  // Errors of depth sensors are correlated in a neighbourhood; that part does not average out.
  const double floor = 0.5 * inverse_noise;
  fit.sigma_p = std::sqrt(sigma(0.0) * sigma(0.0) + floor * floor);
  fit.sigma_q = std::sqrt(sigma(1.0) * sigma(1.0) + floor * floor);
  return fit;
}

bool CoversSegment(const std::vector<DepthSample>& inliers) {
  double last = 0.0;
  for (const DepthSample& s : inliers) {
    if (s.t - last > kMaxHole) return false;
    last = s.t;
  }
  return 1.0 - last <= kMaxHole;
}

std::optional<FittedDepth> FitDepth(const std::vector<DepthSample>& samples, int tried, const DepthSensor& sensor) {
  if (static_cast<int>(samples.size()) < std::max<int>(kMinDepthSamples, static_cast<int>(kMinKnownShare * tried))) {
    return std::nullopt;
  }
  const DepthLine agreed = MostAgreed(samples, sensor);
  std::vector<DepthSample> inliers;
  for (const DepthSample& s : samples) {
    if (std::abs(s.inverse_m - agreed.At(s.t)) <= sensor.Tolerance(s.inverse_m)) inliers.push_back(s);
  }
  const bool enough = static_cast<double>(inliers.size()) >= kMinInlierShare * static_cast<double>(samples.size());
  if (!enough || inliers.size() < kMinDepthSamples || !CoversSegment(inliers)) return std::nullopt;
  return LeastSquares(inliers, sensor.inverse_noise);
}

}  // namespace

void AttachDepthToLines(std::vector<StereoLine>& lines, const cv::Mat& depth16, double depth_units_per_m,
                        const StereoCamera& camera, const StereoOptions& options) {
  if (depth16.empty() || !(depth_units_per_m > 0.0)) return;
  CV_Assert(depth16.type() == CV_16UC1);
  const DepthSensor sensor{depth_units_per_m, options.depth_noise_per_m};
  for (StereoLine& line : lines) {
    const Segment2& s = line.left.segment;
    const double length = s.Length();
    if (!s.p.allFinite() || !s.q.allFinite() || !(length > 0.0)) continue;
    const int count = std::clamp(static_cast<int>(length), kMinDepthSamples, kMaxDepthSamples);
    const auto fit = FitDepth(SampleAlong(depth16, s, count, sensor), count, sensor);
    if (!fit) continue;
    const double fb = camera.FocalBaseline();
    const double p = fb * fit->line.At(0.0);
    const double q = fb * fit->line.At(1.0);
    const double least = options.min_disparity_px;
    const double most = options.max_disparity_px;
    if (!(p >= least && q >= least && p <= most && q <= most)) continue;
    line.disparity_p_px = p;
    line.disparity_q_px = q;
    line.sigma_disparity_p_px = fb * fit->sigma_p;
    line.sigma_disparity_q_px = fb * fit->sigma_q;
  }
}

}  // namespace plslam::vo
