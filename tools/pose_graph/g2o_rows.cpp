// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/g2o_rows.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "core/errors/error_text.h"

namespace plslam {
namespace {

constexpr double kMaxNormError = 0.01;

/// Diagonal of what turns the optimiser's error into the file's.
template <class Pose>
Eigen::Matrix<double, kPoseFreedom<Pose>, 1> FileScale() {
  Eigen::Matrix<double, kPoseFreedom<Pose>, 1> scale;
  scale.setOnes();
  scale.template tail<kPoseFreedom<Pose> - G2oRows<Pose>::kDimension>().setConstant(G2oRows<Pose>::kRotationScale);
  return scale;
}

}  // namespace

SE3 G2oRows<SE3>::Read(const TextRow& row, size_t first) {
  const Eigen::Vector3d t(row.Number(first), row.Number(first + 1), row.Number(first + 2));
  const Eigen::Quaterniond q(row.Number(first + 6), row.Number(first + 3), row.Number(first + 4),
                             row.Number(first + 5));
  const double norm = q.norm();
  if (!(std::abs(norm - 1.0) <= kMaxNormError)) {
    row.Fail(fmt::format("the quaternion's norm is {:.4g}, and must be within 1 % of 1", norm));
  }
  // What is unit to rounding is not changed by reading it again.
  const bool unit = std::abs(norm - 1.0) < 4.0 * std::numeric_limits<double>::epsilon();
  return unit ? SE3::FromUnit(q, t) : SE3(q, t);
}

std::string G2oRows<SE3>::Text(const SE3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  return fmt::format("{} {} {} {} {} {} {}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

SE2 G2oRows<SE2>::Read(const TextRow& row, size_t first) {
  return SE2(row.Number(first + 2), Eigen::Vector2d(row.Number(first), row.Number(first + 1)));
}

std::string G2oRows<SE2>::Text(const SE2& pose) {
  return fmt::format("{} {} {}", pose.translation().x(), pose.translation().y(), pose.angle());
}

int64_t ReadG2oId(const TextRow& row, size_t field) {
  const std::string_view text = row.fields.at(field);
  int64_t id = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size() || id < 0) {
    row.Fail(fmt::format("'{}' is not the number of a vertex (an integer of at least 0)", Shown(text)));
  }
  return id;
}

template <class Pose>
PoseMatrix<Pose> ReadG2oInformation(const TextRow& row, size_t first) {
  const auto scale = FileScale<Pose>();
  PoseMatrix<Pose> information;
  for (int i = 0; i < information.rows(); ++i) {
    for (int j = i; j < information.cols(); ++j) {
      information(i, j) = information(j, i) = scale[i] * scale[j] * row.Number(first++);
    }
  }
  const Eigen::LLT<PoseMatrix<Pose>> cholesky(information);
  if (cholesky.info() != Eigen::Success) row.Fail("the information is not positive definite");
  return information;
}

template <class Pose>
std::string G2oInformationText(const PoseMatrix<Pose>& information) {
  const auto scale = FileScale<Pose>();
  std::string text;
  for (int i = 0; i < information.rows(); ++i) {
    for (int j = i; j < information.cols(); ++j)
      text += fmt::format(" {}", information(i, j) / (scale[i] * scale[j]));
  }
  return text;
}

template PoseMatrix<SE3> ReadG2oInformation<SE3>(const TextRow&, size_t);
template PoseMatrix<SE2> ReadG2oInformation<SE2>(const TextRow&, size_t);
template std::string G2oInformationText<SE3>(const PoseMatrix<SE3>&);
template std::string G2oInformationText<SE2>(const PoseMatrix<SE2>&);

}  // namespace plslam
