// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/imgproc.hpp>

#include "core/geometry/se3.h"
#include "tests/support/changed_images.h"

namespace plslam::test {

/// A rig that was bent after its calibration: the right camera is rotated.
class BentRig : public ChangedImages {
 public:
  BentRig(const Dataset& straight, const Eigen::Vector3d& turn_rad) : ChangedImages(straight) {
    const CameraCalibration& right = straight.rig().right;
    Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
    K(0, 0) = right.fx_px;
    K(1, 1) = right.fy_px;
    K(0, 2) = right.cx_px;
    K(1, 2) = right.cy_px;
    const Eigen::Matrix3d H = K * ExpSO3(turn_rad).toRotationMatrix() * K.inverse();
    homography_ = cv::Mat(3, 3, CV_64F);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) homography_.at<double>(r, c) = H(r, c);
    }
  }
  StereoImages Read(int index) const override {
    StereoImages images = dataset_.Read(index);
    const cv::Mat right = images.right;
    images.right = cv::Mat();
    cv::warpPerspective(right, images.right, homography_, right.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return images;
  }

 private:
  cv::Mat homography_;
};

}  // namespace plslam::test
