#include "vo_process/stereo/stereo_front_end.h"

#include <algorithm>
#include <utility>

#include "vo_process/stereo/stereo_matcher.h"

namespace plslam {
namespace {

// Of an octave of the points: with eight of them, corners are compared up to 14 pixels away.
constexpr double kUnknownRowTolerance_px = 4.0;
constexpr double kUnknownRowSigma_px = 2.0;

/// What the camera leaves out may have more corners than all the rest; the few along the edge of a warped image cost
/// nothing.
ImageFeatures ExtractInside(FeatureExtractor& extractor, const cv::Mat& image, const CameraCalibration& camera,
                            const FeatureMask& mask, std::optional<int> max_points,
                            const RunBoth& run_both = RunInTurn) {
  ImageFeatures features =
      extractor.Extract(image, run_both, camera.mask.empty() ? cv::Mat() : mask.inside(), max_points);
  mask.RemoveOutside(features);
  return features;
}

/// A point without a matching corner is searched by its patch along the row of the right image, also where that is
/// left out.
void ForgetPartnersOutside(const FeatureMask& right_mask, StereoFeatures& features) {
  for (StereoPoint& point : features.points) {
    if (!point.HasDepth() || !right_mask.IsOutside(point.left.px - Eigen::Vector2d(point.disparity_px, 0.0)))
      continue;
    point.disparity_px = -1.0;
    point.row_offset_px = 0.0;
    point.sigma_row_px = -1.0;
  }
}

}  // namespace

StereoFrontEnd::StereoFrontEnd(const RigCalibration& rig, const VoOptions& options)
    : rig_(rig),
      options_(options),
      rectifier_(rig),
      left_mask_(rectifier_.left_mask()),
      right_mask_(rectifier_.right_mask()),
      left_extractor_(options.features),
      right_extractor_(options.features) {}

StereoFeatures StereoFrontEnd::Process(const StereoImages& images, StageTimer& timer, const RowField& rows,
                                       std::optional<int> max_points) {
  const bool rgbd = rig_.kind == RigCalibration::Kind::kRgbd;
  return rgbd ? ProcessRgbd(images, timer, max_points)
              : ProcessStereo(images, timer, rows, max_points, options_.stereo);
}

StereoFeatures StereoFrontEnd::LookForRows(const StereoImages& images, const PairSkew& skew) {
  if (rig_.kind == RigCalibration::Kind::kRgbd || options_.features.features == "lines") return {};
  StereoOptions options = options_.stereo;
  options.row_sigma_px = std::max(options.row_sigma_px, kUnknownRowSigma_px);
  options.point_row_tolerance_px = std::max(options.point_row_tolerance_px, kUnknownRowTolerance_px);
  StageTimer untimed([] { return 0.0; });
  return ProcessStereo(images, untimed, RowField().With(skew), std::nullopt, options);
}

RunBoth StereoFrontEnd::OnBothThreads() {
  return
      [this](const std::function<void()>& here, const std::function<void()>& there) { worker_.RunBoth(here, there); };
}

StereoFeatures StereoFrontEnd::ProcessStereo(const StereoImages& images, StageTimer& timer, const RowField& rows,
                                             std::optional<int> max_points, const StereoOptions& options) {
  cv::Mat left;
  cv::Mat right;
  ImageFeatures left_features;
  ImageFeatures right_features;
  timer.Time("features", [&] {
    worker_.RunBoth(
        [&] {
          left = rectifier_.RectifyLeft(images.left);
          left_features = ExtractInside(left_extractor_, left, rig_.left, left_mask_, max_points);
        },
        [&] {
          right = rectifier_.RectifyRight(images.right);
          right_features = ExtractInside(right_extractor_, right, rig_.right, right_mask_, max_points);
        });
  });
  return timer.Time("stereo", [&] {
    StereoFeatures features =
        MatchStereo(std::move(left_features), std::move(right_features), left, right, rows, options, OnBothThreads());
    if (!rig_.right.mask.empty()) ForgetPartnersOutside(right_mask_, features);
    return features;
  });
}

StereoFeatures StereoFrontEnd::ProcessRgbd(const StereoImages& images, StageTimer& timer,
                                           std::optional<int> max_points) {
  cv::Mat left;
  cv::Mat depth;
  ImageFeatures features;
  timer.Time("features", [&] {
    worker_.RunBoth([&] { left = rectifier_.RectifyLeft(images.left); },
                    [&] { depth = rectifier_.RectifyDepth(images.right); });
    features = ExtractInside(left_extractor_, left, rig_.left, left_mask_, max_points, OnBothThreads());
  });
  return timer.Time("stereo", [&] {
    return AttachDepth(std::move(features), depth, rig_.depth_units_per_m, camera(), options_.stereo);
  });
}

}  // namespace plslam
