// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/row_offsets.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <opencv2/imgproc.hpp>

#include "core/motion/robust.h"

namespace plslam::dense {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr size_t kLeastPoints = 50;
constexpr double kHarmless_px = 0.25;
constexpr double kSureSigmas = 5.0;
constexpr int kRounds = 5;
constexpr double kOutlier = 3.0;  // sigmas
constexpr double kLeastSigma_px = 0.05;
// Standard deviations of the coefficients of real lenses and mounts: they bound the corners, where few points are.
constexpr double kPrior_px[] = {20.0, 5.0, 5.0, 1.0, 1.0, 1.0};

Vector6 Terms(const StereoCamera& camera, double u_px, double v_px) {
  const double x = 2.0 * (u_px - camera.cx_px) / camera.width_px;
  const double y = 2.0 * (v_px - camera.cy_px) / camera.height_px;
  return {1.0, x, y, x * x, x * y, y * y};
}

}  // namespace

double RowOffsets::At(const StereoCamera& camera, double u_px, double v_px) const {
  return Terms(camera, u_px, v_px).dot(coefficients_px);
}

RowOffsets EstimateRows(const StereoFeatures& features, const StereoCamera& camera) {
  std::vector<Vector6> terms;
  std::vector<double> offsets;
  for (const StereoPoint& point : features.points) {
    if (!point.HasDepth() || point.sigma_row_px <= 0.0) continue;
    terms.push_back(Terms(camera, point.left.px.x() - point.disparity_px, point.left.px.y()));
    offsets.push_back(point.row_offset_px);
  }
  if (offsets.size() < kLeastPoints) return {};
  Vector6 field = Vector6::Zero();
  std::vector<double> sorted = offsets;
  field[0] = Median(sorted);
  double sigma_px = 1.0;
  Matrix6 information;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> residuals;
    for (size_t i = 0; i < offsets.size(); ++i) residuals.push_back(std::abs(offsets[i] - terms[i].dot(field)));
    sorted = residuals;
    sigma_px = std::max(kSigmaOfMedian * Median(sorted), kLeastSigma_px);
    information = Matrix6::Zero();
    Vector6 sum = Vector6::Zero();
    for (int i = 0; i < 6; ++i) information(i, i) = sigma_px * sigma_px / (kPrior_px[i] * kPrior_px[i]);
    for (size_t i = 0; i < offsets.size(); ++i) {
      if (residuals[i] > kOutlier * sigma_px) continue;
      information += terms[i] * terms[i].transpose();
      sum += terms[i] * offsets[i];
    }
    field = information.ldlt().solve(sum);
  }
  RowOffsets rows;
  double squares = 0.0;
  Vector6 gradient = Vector6::Zero();
  for (const Vector6& at : terms) {
    squares += at.dot(field) * at.dot(field);
    gradient += at.dot(field) * at;
  }
  const auto n = static_cast<double>(terms.size());
  const double size_px = std::sqrt(squares / n);
  if (size_px < kHarmless_px) return rows;
  gradient /= n * size_px;
  const double sigma_of_size_px = sigma_px * std::sqrt(gradient.dot(information.ldlt().solve(gradient)));
  if (size_px < kSureSigmas * sigma_of_size_px) return rows;
  rows.coefficients_px = field;
  rows.size_px = size_px;
  rows.sigma_px = sigma_of_size_px;
  return rows;
}

cv::Mat StraightenRows(const cv::Mat& right, const RowOffsets& rows, const StereoCamera& camera) {
  if (rows.is_zero()) return right;
  cv::Mat column(right.size(), CV_32F), row(right.size(), CV_32F), straight;
  for (int y = 0; y < right.rows; ++y) {
    for (int x = 0; x < right.cols; ++x) {
      column.at<float>(y, x) = static_cast<float>(x);
      row.at<float>(y, x) = static_cast<float>(y + rows.At(camera, x, y));
    }
  }
  cv::remap(right, straight, column, row, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return straight;
}

}  // namespace plslam::dense
