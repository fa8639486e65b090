#include "vo_process/stereo/patch_tracker.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace plslam {
namespace {

constexpr int kMaxTrackIterations = 10;
constexpr double kMaxTrackTravel = 2.0;
/// What residuals and shape do not show: interpolation, surfaces that are not flat.
constexpr double kTrackModelError = 0.05;
/// Gradients must have this many times the energy that noise alone gives them, in every direction.
constexpr double kMinSignal = 4.0;
/// Smaller to larger eigenvalue of the gradients. A weak corner on a strong edge is pulled along by the edge wherever the
/// expected shape is a little wrong.
constexpr double kMinFirmness = 0.2;
/// Changes of size beyond which the patch shows too little of what it showed.
constexpr double kMinZoom = 0.4;
constexpr double kMaxZoom = 2.5;

bool Inside(const cv::Mat& image, const Eigen::Vector2d& place) {
  // One pixel more than the patch for its gradients.
  constexpr double kMargin = kHalf + 2;
  return place.x() >= kMargin && place.y() >= kMargin && place.x() <= image.cols - 1 - kMargin &&
         place.y() <= image.rows - 1 - kMargin;
}

double SmallerEigenvalue(const Eigen::Matrix2d& m) {
  const double half_trace = 0.5 * m.trace();
  return half_trace - std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
}

/// Energy that noise of the reference patch gives to its gradients in each direction: half of the residual variance is
/// the reference's, and central differences halve it.
double GradientEnergyOfNoise(double noise) { return 0.25 * noise * noise * kPixels; }

void Differentiate(const PatchPixels& source, ReferencePatch& patch) {
  constexpr int kStride = PatchPixels::kRim;
  patch.pixels.setZero();
  patch.derivative_u.setZero();
  patch.derivative_v.setZero();
  for (int y = 0; y < kSide; ++y) {
    const uint8_t* row = source.pixels.data() + (y + 1) * kStride + 1;
    for (int x = 0; x < kSide; ++x) {
      patch.pixels(x, y) = row[x];
      patch.derivative_u(x, y) = 0.5F * static_cast<float>(row[x + 1] - row[x - 1]);
      patch.derivative_v(x, y) = 0.5F * static_cast<float>(row[x + kStride] - row[x - kStride]);
    }
  }
}

/// Makes a derivative blind to offset and gain of brightness.
void Project(const ReferencePatch& patch, Patch& derivative) {
  RemoveMean(derivative);
  derivative -= patch.pixels * (Dot(derivative, patch.pixels) / static_cast<float>(patch.energy));
}

/// What errors of the four entries of the shape, each of deviation 1, do to the place.
double ShapeSensitivity(const ReferencePatch& patch) {
  const Eigen::Matrix2d inverse = patch.hessian.inverse();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  Patch weighted;
  for (const Patch* derivative : {&patch.derivative_u, &patch.derivative_v}) {
    for (const bool along_u : {true, false}) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kRow; ++x) {
          weighted(x, y) = (*derivative)(x, y) * static_cast<float>((along_u ? x : y) - kHalf);
        }
      }
      const Eigen::Vector2d cross(Dot(patch.derivative_u, weighted), Dot(patch.derivative_v, weighted));
      const Eigen::Vector2d shift = inverse * cross;
      covariance += shift * shift.transpose();
    }
  }
  return std::sqrt(std::max(covariance.trace() - SmallerEigenvalue(covariance), 0.0));
}

/// Grey levels around `center`, bilinear, at the places that `shape` takes those of a patch to. False where that leaves
/// the image.
bool Sample(const cv::Mat& image, const Eigen::Vector2d& center, const Eigen::Matrix2d& shape, Patch& patch) {
  const double reach_u = kHalf * (std::abs(shape(0, 0)) + std::abs(shape(0, 1)));
  const double reach_v = kHalf * (std::abs(shape(1, 0)) + std::abs(shape(1, 1)));
  const bool inside = center.x() - reach_u >= 1.0 && center.y() - reach_v >= 1.0 &&
                      center.x() + reach_u < image.cols - 2 && center.y() + reach_v < image.rows - 2;
  if (!inside) return false;
  const auto du = static_cast<float>(shape(0, 0));
  const auto dv = static_cast<float>(shape(1, 0));
  const auto stride = static_cast<int>(image.step);
  for (int y = 0; y < kSide; ++y) {
    const Eigen::Vector2d begin = center + shape * Eigen::Vector2d(-kHalf, y - kHalf);
    const auto u0 = static_cast<float>(begin.x());
    const auto v0 = static_cast<float>(begin.y());
    for (int x = 0; x < kSide; ++x) {
      const float u = u0 + du * static_cast<float>(x);
      const float v = v0 + dv * static_cast<float>(x);
      const int iu = static_cast<int>(u);
      const int iv = static_cast<int>(v);
      const float fu = u - static_cast<float>(iu);
      const float fv = v - static_cast<float>(iv);
      const uint8_t* p = image.data + iv * stride + iu;
      const auto a = static_cast<float>(p[0]);
      const auto b = static_cast<float>(p[stride]);
      const float top = a + fu * (static_cast<float>(p[1]) - a);
      const float bottom = b + fu * (static_cast<float>(p[stride + 1]) - b);
      patch(x, y) = top + fv * (bottom - top);
    }
  }
  patch.bottomRows<1>().setZero();
  return true;
}

/// What comparing the reference with a patch of now says.
struct TrackComparison {
  double gain = 0.0;
  double correlation = 0.0;
  /// Residual standard deviation in grey levels of the reference.
  double noise = 0.0;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
};

std::optional<TrackComparison> Compare(const ReferencePatch& reference, const Patch& now) {
  const double sum = now.sum();
  const double energy = Dot(now, now) - sum * sum / kPixels;
  const double cross = Dot(reference.pixels, now);
  if (!(energy > 0.0) || !(cross > 0.0)) return std::nullopt;
  TrackComparison c;
  c.gain = cross / reference.energy;
  c.correlation = cross / std::sqrt(reference.energy * energy);
  c.gradient = Eigen::Vector2d(Dot(reference.derivative_u, now), Dot(reference.derivative_v, now)) / c.gain;
  const double residual = energy / (c.gain * c.gain) - reference.energy;
  c.noise = std::max(std::sqrt(std::max(residual, 0.0) / (kPixels - 4)), kMinNoise);
  return c;
}

/// In pixels of the patch; nullopt where noise makes up too much of the gradients.
std::optional<double> Deviation(const ReferencePatch& reference, double noise, double shape_sigma) {
  const double signal = SmallerEigenvalue(reference.hessian);
  const double from_noise = GradientEnergyOfNoise(noise);
  if (!(signal > kMinSignal * from_noise)) return std::nullopt;
  // The true gradients are weaker than they look.
  const double inflation = signal / (signal - from_noise);
  const double from_residuals = inflation * noise / std::sqrt(signal);
  return std::hypot(from_residuals, shape_sigma * reference.shape_sensitivity, kTrackModelError);
}

}  // namespace

std::optional<PatchPixels> TakePatch(const ImageLevels& image, const Eigen::Vector2d& px, double scale) {
  if (image.empty() || !px.allFinite()) return std::nullopt;
  const ImageLevels::Level& level = image.LevelFor(scale);
  const Eigen::Vector2d place = level.FromImage(px);
  if (!Inside(level.image, place)) return std::nullopt;
  const Eigen::Vector2d center = place.array().round();
  PatchPixels patch;
  patch.size_px = level.size_px;
  patch.off_center = place - center;
  const int u = static_cast<int>(center.x()) - kHalf - 1;
  const int v = static_cast<int>(center.y()) - kHalf - 1;
  for (int y = 0; y < PatchPixels::kRim; ++y) {
    std::copy_n(level.image.ptr<uint8_t>(v + y) + u, PatchPixels::kRim, patch.pixels.data() + y * PatchPixels::kRim);
  }
  return patch;
}

std::optional<ReferencePatch> MakeReferencePatch(const PatchPixels& pixels) {
  ReferencePatch patch;
  patch.size_px = pixels.size_px;
  patch.off_center = pixels.off_center;
  Differentiate(pixels, patch);
  RemoveMean(patch.pixels);
  patch.energy = Dot(patch.pixels, patch.pixels);
  if (!(patch.energy > kPixels * kMinNoise * kMinNoise)) return std::nullopt;
  Project(patch, patch.derivative_u);
  Project(patch, patch.derivative_v);
  const double uv = Dot(patch.derivative_u, patch.derivative_v);
  patch.hessian << Dot(patch.derivative_u, patch.derivative_u), uv, uv, Dot(patch.derivative_v, patch.derivative_v);
  const double signal = SmallerEigenvalue(patch.hessian);
  const bool corner = signal > kMinSignal * GradientEnergyOfNoise(kMinNoise) &&
                      signal > kMinFirmness * (patch.hessian.trace() - signal);
  if (!corner) return std::nullopt;
  patch.shape_sensitivity = ShapeSensitivity(patch);
  return patch;
}

std::optional<TrackedPatch> TrackPatch(const ReferencePatch& reference, const ImageLevels& image,
                                       const PatchExpectation& expected) {
  if (image.empty() || !expected.px.allFinite() || !expected.now_from_then.allFinite()) return std::nullopt;
  const double zoom = std::sqrt(std::abs(expected.now_from_then.determinant()));
  if (!(zoom >= kMinZoom && zoom <= kMaxZoom)) return std::nullopt;
  const ImageLevels::Level& level = image.LevelFor(reference.size_px * zoom);
  const Eigen::Matrix2d shape = expected.now_from_then * (reference.size_px / level.size_px);
  const Eigen::Vector2d off_center = shape * reference.off_center;
  const Eigen::Matrix2d step_from_gradient = shape * reference.hessian.inverse();
  const Eigen::Vector2d start = level.FromImage(expected.px) - off_center;
  Eigen::Vector2d center = start;
  Patch now;
  for (int iteration = 0; iteration < kMaxTrackIterations; ++iteration) {
    if (!Sample(level.image, center, shape, now)) return std::nullopt;
    const std::optional<TrackComparison> c = Compare(reference, now);
    if (!c) return std::nullopt;
    const Eigen::Vector2d step = step_from_gradient * c->gradient;
    center -= step;
    if (!((center - start).norm() <= kMaxTrackTravel)) return std::nullopt;
    if (step.cwiseAbs().maxCoeff() > kPatchConverged) continue;
    const std::optional<double> deviation = Deviation(reference, c->noise, expected.shape_sigma);
    if (!deviation) return std::nullopt;
    return TrackedPatch{level.ToImage(center + off_center), *deviation * level.size_px, c->correlation, c->gain};
  }
  return std::nullopt;
}

}  // namespace plslam
