// SPDX-License-Identifier: BSD-3-Clause
#include "tests/tools/body_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

namespace plslam::test {
namespace {

using synthetic::Footprint;
using synthetic::Texture;

// A face at a pixel (x, y): its coordinates (0 to 1) are U.(x, y, 1) / W.(x, y, 1) and V.(x, y, 1) / W.(x, y, 1): a
// homography.
struct Homography {
  Eigen::RowVector3d U;
  Eigen::RowVector3d V;
  Eigen::RowVector3d W;
  bool visible = false;
};

Homography HomographyOf(const BodyFace& face, const StereoCamera& camera, const SE3& T_b_cam) {
  const Eigen::Vector3d n = face.s.cross(face.t);
  const Eigen::Vector3d from_corner = T_b_cam.translation() - face.corner;
  const double k = -n.dot(from_corner);
  Eigen::Matrix3d K_inverse = Eigen::Matrix3d::Identity();
  K_inverse(0, 0) = K_inverse(1, 1) = 1.0 / camera.f_px;
  K_inverse(0, 2) = -camera.cx_px / camera.f_px;
  K_inverse(1, 2) = -camera.cy_px / camera.f_px;
  const Eigen::Matrix3d ray = T_b_cam.R() * K_inverse;
  const auto row = [&](const Eigen::Vector3d& side) -> Eigen::RowVector3d {
    return (from_corner.dot(side) * n + k * side).transpose() / side.squaredNorm() * ray;
  };
  return {row(face.s), row(face.t), n.transpose() * ray, k > 0.0};
}

// Share of a pixel inside, from how far inside its centre is, in pixels.
double Inside(double distance_px) { return std::clamp(distance_px + 0.5, 0.0, 1.0); }

void AddFace(const BodyFace& face, const Texture& texture, const Homography& h, cv::Mat* sum, cv::Mat* coverage) {
  const double texels_u = texture.width();
  const double texels_v = texture.height();
  for (int y = 0; y < sum->rows; ++y) {
    for (int x = 0; x < sum->cols; ++x) {
      const Eigen::Vector3d px(x, y, 1.0);
      const double w = h.W.dot(px);
      if (w <= 0.0) continue;
      const double u = h.U.dot(px) / w;
      const double v = h.V.dot(px) / w;
      const Eigen::RowVector2d du = (h.U - u * h.W).head<2>() / w;
      const Eigen::RowVector2d dv = (h.V - v * h.W).head<2>() / w;
      const double share = Inside(std::min(u, 1.0 - u) / du.norm()) * Inside(std::min(v, 1.0 - v) / dv.norm());
      if (share <= 0.0) continue;
      const Footprint footprint = {static_cast<float>(texels_u * du[0]), static_cast<float>(texels_v * dv[0]),
                                   static_cast<float>(texels_u * du[1]), static_cast<float>(texels_v * dv[1])};
      const float value =
          texture.Sample(static_cast<float>(u * texels_u), static_cast<float>(v * texels_v), footprint);
      sum->at<float>(y, x) += static_cast<float>(share * face.light) * value;
      coverage->at<float>(y, x) += static_cast<float>(share);
    }
  }
}

}  // namespace

Body MakeBox(const Eigen::Vector3d& size_m, std::vector<Texture> textures) {
  const Eigen::Vector3d x(size_m.x(), 0.0, 0.0);
  const Eigen::Vector3d y(0.0, size_m.y(), 0.0);
  const Eigen::Vector3d z(0.0, 0.0, size_m.z());
  const auto texture = [&](size_t i) { return std::min(i, textures.size() - 1); };
  const Eigen::Vector3d o = -0.5 * size_m;
  const std::vector<BodyFace> faces = {{o, x, y, texture(0), 1.0},
                                       {o + z, -z, y, texture(1), 0.85},
                                       {o + x, z, y, texture(2), 0.8},
                                       {o + x + z, -x, y, texture(3), 1.0},
                                       {o + z, x, -z, texture(4), 1.1}};
  return {faces, std::move(textures)};
}

BodyPicture PictureOfBody(const Body& body, const StereoCamera& camera, const SE3& T_b_cam) {
  BodyPicture picture;
  picture.value = cv::Mat::zeros(camera.height_px, camera.width_px, CV_32F);
  picture.coverage = cv::Mat::zeros(camera.height_px, camera.width_px, CV_32F);
  for (const BodyFace& face : body.faces) {
    const Homography h = HomographyOf(face, camera, T_b_cam);
    if (h.visible) AddFace(face, body.textures[face.texture], h, &picture.value, &picture.coverage);
  }
  picture.value.forEach<float>([&](float& value, const int* at) {
    float& coverage = picture.coverage.at<float>(at[0], at[1]);
    value = coverage > 0.0F ? value / coverage : 0.0F;
    coverage = std::min(coverage, 1.0F);
  });
  return picture;
}

void Paste(const BodyPicture& picture, double sigma, uint64_t seed, cv::Mat* image) {
  cv::Mat noise(image->size(), CV_32F);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  image->forEach<uint8_t>([&](uint8_t& value, const int* at) {
    const float share = picture.coverage.at<float>(at[0], at[1]);
    if (share <= 0.0F) return;
    const float body = picture.value.at<float>(at[0], at[1]) + noise.at<float>(at[0], at[1]);
    value = cv::saturate_cast<uint8_t>(share * body + (1.0F - share) * static_cast<float>(value));
  });
}

void AddNoise(double sigma, uint64_t seed, cv::Mat* image) {
  cv::Mat noise(image->size(), CV_32F);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  image->forEach<uint8_t>([&](uint8_t& value, const int* at) {
    value = cv::saturate_cast<uint8_t>(static_cast<float>(value) + noise.at<float>(at[0], at[1]));
  });
}

}  // namespace plslam::test
