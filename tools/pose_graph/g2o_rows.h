// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/io/files/text_rows.h"
#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// How g2o writes a pose: its tags and numbers.
template <class Pose>
struct G2oRows;

template <>
struct G2oRows<SE3> {
  static constexpr const char* kVertex = "VERTEX_SE3:QUAT";
  static constexpr const char* kEdge = "EDGE_SE3:QUAT";
  static constexpr int kDimension = 3;
  /// x y z qx qy qz qw
  static constexpr int kNumbers = 7;
  /// What the file's error of the rotation is of the optimiser's.
  static constexpr double kRotationScale = 0.5;
  static SE3 Read(const TextRow& row, size_t first);
  static std::string Text(const SE3& pose);
};

template <>
struct G2oRows<SE2> {
  static constexpr const char* kVertex = "VERTEX_SE2";
  static constexpr const char* kEdge = "EDGE_SE2";
  static constexpr int kDimension = 2;
  /// x y angle
  static constexpr int kNumbers = 3;
  static constexpr double kRotationScale = 1.0;
  static SE2 Read(const TextRow& row, size_t first);
  static std::string Text(const SE2& pose);
};

/// A non-negative integer, or `Fail`.
int64_t ReadG2oId(const TextRow& row, size_t field);

/// The upper triangle, row by row, from `first` on; `Fail`s where it is not positive definite.
template <class Pose>
PoseMatrix<Pose> ReadG2oInformation(const TextRow& row, size_t first);

/// The same as text, each number after a blank.
template <class Pose>
std::string G2oInformationText(const PoseMatrix<Pose>& information);

}  // namespace plslam
