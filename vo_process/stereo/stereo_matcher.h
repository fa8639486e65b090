#pragma once

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/image/run_both.h"
#include "core/features/options.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/stereo/row_field.h"

namespace plslam {

/// Stereo matches of both feature types (PL-SLAM §IV.A-B): row buckets, mutual best, ratio test, then sub-pixel
/// disparity by comparing the images, with its standard deviation. All left features are kept; those without a match,
/// and segments nearly parallel to the baseline, have no depth. `rows` tells how rows of the two differ. `run_both`
/// shares the work between two threads.
StereoFeatures MatchStereo(ImageFeatures left, ImageFeatures right, const cv::Mat& left_image,
                           const cv::Mat& right_image, const RowField& rows, const StereoOptions& options,
                           const RunBoth& run_both = RunInTurn);

/// The same for a depth map aligned with the left image (16 bits, 0 = unknown): virtual right measurements
/// d = b f / Z, the lines' from depths sampled robustly along the segment.
StereoFeatures AttachDepth(ImageFeatures left, const cv::Mat& depth, double depth_units_per_m,
                           const StereoCamera& camera, const StereoOptions& options);

}  // namespace plslam
