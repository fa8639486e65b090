// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include <opencv2/core/mat.hpp>

#include "core/datasets/dataset.h"
#include "core/geometry/rectifier.h"

namespace plslam::exports {

/// Computes the rectified left images of a map's keyframes again from the dataset.
class KeyframeImages {
 public:
  /// Throws std::runtime_error where the rectified camera of the dataset is not `camera`.
  KeyframeImages(std::shared_ptr<const Dataset> dataset, const StereoCamera& camera);

  /// Returns the image taken at that time, 8-bit grey; nullopt if the dataset has none. Throws DatasetError if the
  /// image cannot be read.
  std::optional<cv::Mat> At(int64_t t_ns) const;

  /// Left camera as calibrated (l) from rectified left camera (c).
  SE3 T_l_c() const { return {rectifier_->q_l_c(), Eigen::Vector3d::Zero()}; }

 private:
  std::shared_ptr<const Dataset> dataset_;
  std::unique_ptr<Rectifier> rectifier_;
  std::map<int64_t, int> index_of_;
};

}  // namespace plslam::exports
