// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/rolling_shutter.h"

#include <algorithm>
#include <utility>

#include "core/motion/robust.h"

namespace plslam::vo {
namespace {

double StampShare(StampRow stamp) { return stamp == StampRow::kFirst ? 0.0 : stamp == StampRow::kMiddle ? 0.5 : 1.0; }

/// Median disparity of a frame's points and lines; 0 (infinitely far) without any.
double TypicalDisparity(const StereoFeatures& features) {
  std::vector<double> disparities;
  for (const StereoPoint& point : features.points) {
    if (point.HasDepth()) disparities.push_back(point.disparity_px);
  }
  for (const StereoLine& line : features.lines) {
    if (line.HasDepth()) disparities.push_back(line.MiddleDisparity_px());
  }
  return disparities.empty() ? 0.0 : Median(disparities);
}

Eigen::Vector3d WithDisparity(const Eigen::Vector2d& px, double disparity_px) {
  return {px.x(), px.y(), disparity_px};
}

RowShares Mean(const RowShares& a, const RowShares& b) {
  return {0.5 * (a.left + b.left), 0.5 * (a.right + b.right)};
}

}  // namespace

RollingShutter::RollingShutter(const Rectification& rectification, double readout_s, StampRow stamp)
    : rectification_(rectification),
      camera_(rectification.camera),
      readout_s_(readout_s),
      stamp_share_(StampShare(stamp)) {}

RowShares RollingShutter::SharesOf(const Eigen::Vector2d& left_px, double disparity_px) const {
  const auto share = [this](const RectifiedView& view, const Eigen::Vector2d& px) {
    const auto raw = rectification_->identity ? std::optional(px) : view.RawPixel(camera_, px);
    return (raw ? raw->y() / view.calibration().height_px : 0.5) - stamp_share_;
  };
  const double left = share(rectification_->left, left_px);
  if (disparity_px <= 0.0 || rectification_->identity) return {left, left};
  return {left, share(rectification_->right, left_px - Eigen::Vector2d(disparity_px, 0.0))};
}

Eigen::Vector3d RollingShutter::Moved(const Eigen::Vector3d& uvd, const RowShares& shares,
                                      const Vector6d& velocity) const {
  // Infinitely far features only turn; a tiny disparity stands for theirs.
  constexpr double kFar_px = 1e-3;
  Eigen::Vector3d measured(uvd.x(), uvd.y(), std::max(uvd.z(), kFar_px));
  Eigen::Vector3d p_c = camera_.Backproject(measured);
  if (p_c.z() < camera_.MinDepth()) return uvd;
  if (shares.right != shares.left) {
    // The right pixel at the time of the left one.
    const double later_s = readout_s_ * (shares.right - shares.left);
    const Eigen::Vector3d p_later = SE3::Exp(-later_s * velocity) * p_c;
    if (p_later.z() < camera_.MinDepth()) return uvd;
    const auto right_u = [this](const Eigen::Vector3d& p) {
      return camera_.f_px * (p.x() - camera_.baseline_m) / p.z();
    };
    measured.z() = std::max(measured.z() + right_u(p_later) - right_u(p_c), kFar_px);
    p_c = camera_.Backproject(measured);
  }
  const Eigen::Vector3d p_stamp = SE3::Exp(readout_s_ * shares.left * velocity) * p_c;
  if (p_stamp.z() < camera_.MinDepth()) return uvd;
  return camera_.ProjectStereo(p_stamp);
}

RollingFrame::RollingFrame(const RollingShutter& shutter, StereoFeatures measured)
    : shutter_(shutter), measured_(std::move(measured)) {
  const double typical_px = TypicalDisparity(measured_);
  const auto known = [typical_px](double disparity_px) { return disparity_px > 0.0 ? disparity_px : typical_px; };
  for (const StereoPoint& point : measured_.points) {
    point_shares_.push_back(shutter_.SharesOf(point.left.px, point.disparity_px));
    point_disparities_px_.push_back(known(point.disparity_px));
  }
  for (const StereoLine& line : measured_.lines) {
    line_shares_.push_back({shutter_.SharesOf(line.left.segment.p, line.disparity_p_px),
                            shutter_.SharesOf(line.left.segment.q, line.disparity_q_px)});
    line_disparities_px_.push_back({known(line.disparity_p_px), known(line.disparity_q_px)});
  }
}

StereoFeatures RollingFrame::MovedBy(const Vector6d& velocity) const {
  StereoFeatures moved = measured_;
  for (size_t i = 0; i < moved.points.size(); ++i) {
    StereoPoint& point = moved.points[i];
    const Eigen::Vector3d uvd =
        shutter_.Moved(WithDisparity(point.left.px, point_disparities_px_[i]), point_shares_[i], velocity);
    point.left.px = uvd.head<2>();
    if (point.HasDepth()) point.disparity_px = uvd.z();
  }
  for (size_t i = 0; i < moved.lines.size(); ++i) moved.lines[i] = Moved(i, velocity);
  return moved;
}

// Along an edge, time and image velocity are nearly linear, so the edge is a parabola of some height h in the image.
// The straight fit is at 2/3 h from its ends, and moving the fit as if it were the edge bends it by -h.
StereoLine RollingFrame::Moved(size_t index, const Vector6d& velocity) const {
  StereoLine line = measured_.lines[index];
  const auto& [shares_p, shares_q] = line_shares_[index];
  const auto& [disparity_p_px, disparity_q_px] = line_disparities_px_[index];
  const Eigen::Vector3d p = WithDisparity(line.left.segment.p, disparity_p_px);
  const Eigen::Vector3d q = WithDisparity(line.left.segment.q, disparity_q_px);
  const Eigen::Vector3d moved_p = shutter_.Moved(p, shares_p, velocity);
  const Eigen::Vector3d moved_q = shutter_.Moved(q, shares_q, velocity);
  const Eigen::Vector3d middle = shutter_.Moved(0.5 * (p + q), Mean(shares_p, shares_q), velocity);
  const Eigen::Vector3d bend = middle - 0.5 * (moved_p + moved_q);
  const Eigen::Vector3d true_p = moved_p + 2.0 / 3.0 * bend;
  const Eigen::Vector3d true_q = moved_q + 2.0 / 3.0 * bend;
  line.left.segment = {true_p.head<2>(), true_q.head<2>()};
  if (!line.HasDepth()) return line;
  line.disparity_p_px = true_p.z();
  line.disparity_q_px = true_q.z();
  return line;
}

}  // namespace plslam::vo
