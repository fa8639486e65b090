// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "core/files/text_rows.h"
#include "core/optim/pose_graph/pose_graph.h"

namespace plslam::pose_graph {

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
  /// Ratio of the file's rotation error to the optimiser's.
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

/// Reads the upper triangle, row by row, from `first` on; `Fail`s if it is not positive definite.
template <class Pose>
PoseMatrix<Pose> ReadG2oInformation(const TextRow& row, size_t first);

/// The same as text, each number after a blank.
template <class Pose>
std::string G2oInformationText(const PoseMatrix<Pose>& information);

/// A pose graph in the form of g2o files: poses with ids.
template <class Pose>
struct G2oGraph {
  /// Ascending; as long as `graph.poses`.
  std::vector<int64_t> ids;
  /// Information is that of the optimiser's error; in files it refers to the vector part of the quaternion, which is
  /// half of it.
  PoseGraph<Pose> graph;
  /// Whether the file has a VERTEX for the pose; identity if not (see ChainedPoses).
  std::vector<bool> given;
};

struct G2oFile {
  std::variant<G2oGraph<SE3>, G2oGraph<SE2>> content;
  /// Tags that do not concern the graph (PARAMS_...), with how many lines have them.
  std::map<std::string, int> skipped;
};

/// Reads VERTEX_SE3:QUAT, EDGE_SE3:QUAT or VERTEX_SE2, EDGE_SE2, and FIX. Poses are those that any line names.
/// Quaternions are normalised. Throws std::runtime_error, with file and line, for any other tag, for space and plane
/// in one file, a vertex twice, quaternions more than 1 % from unit, information that is not positive definite, and
/// numbers too few, too many or not finite; and for files without an edge.
G2oFile ReadG2o(const std::string& path);

/// Writes a file beside it and renames that. Reading it again gives equal values to the last bit. Poses that are not
/// `given` are left out.
void WriteG2o(const std::string& path, const G2oGraph<SE3>& graph);
void WriteG2o(const std::string& path, const G2oGraph<SE2>& graph);

}  // namespace plslam::pose_graph
