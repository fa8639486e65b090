// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "core/datasets/dataset.h"
#include "core/geometry/rectifier.h"

namespace plslam {

/// The rectified left images that a map's keyframes were made of, from the dataset again.
class KeyframeImages {
 public:
  /// Throws std::runtime_error where the dataset cannot be opened, or its rectified camera is not `camera`.
  KeyframeImages(const std::string& dataset, const StereoCamera& camera);

  /// The image taken at that time, 8-bit grey; nullopt where the dataset has none. Throws DatasetError where it has
  /// one that cannot be read.
  std::optional<cv::Mat> At(int64_t t_ns) const;

  /// Left camera as calibrated (l) from rectified left camera (c).
  SE3 T_l_c() const { return {rectifier_->q_l_c(), Eigen::Vector3d::Zero()}; }

 private:
  std::unique_ptr<Dataset> dataset_;
  std::unique_ptr<Rectifier> rectifier_;
  std::map<int64_t, int> index_of_;
};

}  // namespace plslam
