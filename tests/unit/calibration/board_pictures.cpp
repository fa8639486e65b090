// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/calibration/board_pictures.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/geometry/distortion.h"

namespace plslam::test {

RigCalibration KnownRig(const std::string& model) {
  RigCalibration rig;
  for (const bool is_right : {false, true}) {
    const double k = is_right ? 0.9 : 1.0;
    CameraCalibration& camera = is_right ? rig.right : rig.left;
    camera.width_px = 640;
    camera.height_px = 480;
    camera.model = model;
    camera.fx_px = is_right ? 462.0 : 458.0;
    camera.fy_px = is_right ? 461.0 : 457.0;
    camera.cx_px = is_right ? 317.0 : 325.0;
    camera.cy_px = is_right ? 243.0 : 236.0;
    if (model == "radtan") camera.distortion = {-0.28 * k, 0.07 * k, 0.0002, -0.0004, 0.002};
    if (model == "equidistant") camera.distortion = {-0.02 * k, 0.01 * k, -0.006, 0.001};
    if (model == "rational") camera.distortion = {0.9, 0.12, 0.0002, -0.0004, 0.004, 1.2 + 0.05 * k, 0.35 * k, 0.02};
    if (model == "double_sphere") {
      camera.distortion = {-0.2 * k, 0.55};
      // The image is scaled by 1 / (1 + xi) in its centre.
      camera.fx_px *= 1.0 - 0.2 * k;
      camera.fy_px *= 1.0 - 0.2 * k;
    }
  }
  rig.right.T_b_cam = SE3::Exp((Vector6d() << 0.12, 0.001, -0.002, 0.004, -0.01, 0.006).finished());
  return rig;
}

std::vector<SE3> BoardPoses(const calibration::Board& board, int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Eigen::Vector3d middle(0.5 * board.width_m(), 0.5 * board.height_m(), 0.0);
  std::vector<SE3> poses;
  for (int i = 0; i < n; ++i) {
    const double depth_m = 0.55 + 0.25 * unit(random);
    const double y_m = depth_m * 0.33 * unit(random);
    const Eigen::Vector3d at(depth_m * 0.45 * unit(random), y_m, depth_m);
    const double about_z = 0.5 * unit(random);
    const double about_y = 0.75 * unit(random);
    const Eigen::Vector3d turn(0.75 * unit(random), about_y, about_z);
    const SE3 T(Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())), at);
    poses.push_back(T * SE3(Eigen::Quaterniond::Identity(), -middle));
  }
  return poses;
}

calibration::BoardView SeenBoard(const calibration::Board& board, const CameraCalibration& camera,
                                 const SE3& T_camera_board, double sigma_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma_px);
  const Distortion distortion(camera);
  const std::vector<Eigen::Vector2d> corners = calibration::BoardCorners(board);
  calibration::BoardView view;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d p = T_camera_board * Eigen::Vector3d(corners[i].x(), corners[i].y(), 0.0);
    if (p.z() < 0.05) continue;
    const auto xy = distortion.Distort({p.x() / p.z(), p.y() / p.z()});
    if (!xy) continue;
    const Eigen::Vector2d pixel(camera.fx_px * xy->x() + camera.cx_px, camera.fy_px * xy->y() + camera.cy_px);
    if (pixel.x() < 3 || pixel.y() < 3 || pixel.x() > camera.width_px - 4 || pixel.y() > camera.height_px - 4)
      continue;
    view.corners.push_back(static_cast<int>(i));
    const double noise_y_px = noise(random);
    view.pixels.emplace_back(pixel.x() + noise(random), pixel.y() + noise_y_px);
  }
  const bool whole = view.corners.size() == corners.size();
  if (board.kind == calibration::Board::Kind::kChess ? !whole : view.corners.size() < 8) return {};
  return view;
}

CameraRays RaysOf(const CameraCalibration& camera) {
  CameraRays rays{camera, {}};
  const Distortion distortion(camera);
  for (int v = 0; v <= camera.height_px; ++v) {
    for (int u = 0; u <= camera.width_px; ++u) {
      rays.corners.push_back(
          distortion.Undistort({(u - 0.5 - camera.cx_px) / camera.fx_px, (v - 0.5 - camera.cy_px) / camera.fy_px})
              .value());
    }
  }
  return rays;
}

cv::Mat RenderBoard(const calibration::Board& board, const CameraRays& rays, const SE3& T_camera_board, double sigma,
                    unsigned seed) {
  const CameraCalibration& camera = rays.camera;
  constexpr int kSamples = 3;
  constexpr double kGrain_m = 0.00025;
  const double width_m = board.width_m(), height_m = board.height_m();
  cv::Mat print(static_cast<int>(std::lround(height_m / kGrain_m)), static_cast<int>(std::lround(width_m / kGrain_m)),
                CV_8UC1, cv::Scalar(230));
  for (const calibration::BlackRectangle& r : calibration::BoardPattern(board)) {
    const Eigen::Vector2d from = r.upper_left_m / kGrain_m, to = (r.upper_left_m + r.size_m) / kGrain_m;
    for (int y = static_cast<int>(std::lround(from.y())); y < static_cast<int>(std::lround(to.y())); ++y) {
      for (int x = static_cast<int>(std::lround(from.x())); x < static_cast<int>(std::lround(to.x())); ++x) {
        print.at<uchar>(y, x) = 25;
      }
    }
  }
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma);
  const Eigen::Matrix3d R = T_camera_board.R();
  const SE3 T_board_camera = T_camera_board.Inverse();
  const double distance = R.col(2).dot(T_camera_board.translation());
  const double margin_m = board.square_m;
  const auto grey = [&](const Eigen::Vector2d& xy) {
    const Eigen::Vector3d ray(xy.x(), xy.y(), 1.0);
    const double depth = distance / R.col(2).dot(ray);
    if (!(depth > 0.0)) return 120.0;
    const Eigen::Vector3d p = T_board_camera * Eigen::Vector3d(depth * ray);
    if (p.x() < -margin_m || p.y() < -margin_m || p.x() > width_m + margin_m || p.y() > height_m + margin_m) {
      return 120.0;
    }
    const int x = static_cast<int>(std::floor(p.x() / kGrain_m)), y = static_cast<int>(std::floor(p.y() / kGrain_m));
    if (x < 0 || y < 0 || x >= print.cols || y >= print.rows) return 230.0;
    return static_cast<double>(print.at<uchar>(y, x));
  };
  cv::Mat image(camera.height_px, camera.width_px, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      double sum = 0.0;
      const Eigen::Vector2d &a = rays.At(u, v), &b = rays.At(u + 1, v), &c = rays.At(u, v + 1);
      for (int i = 0; i < kSamples * kSamples; ++i) {
        sum += grey(a + (i % kSamples + 0.5) / kSamples * (b - a) + (i / kSamples + 0.5) / kSamples * (c - a));
      }
      image.at<uchar>(v, u) = static_cast<uchar>(std::clamp(sum / (kSamples * kSamples) + noise(random), 0.0, 255.0));
    }
  }
  return image;
}

}  // namespace plslam::test
