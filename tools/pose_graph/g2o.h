// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// A pose graph as g2o files have it: poses with names.
template <class Pose>
struct G2oGraph {
  /// Ascending; as long as `graph.poses`.
  std::vector<int64_t> ids;
  /// Information is that of the optimiser's error; files have it for the vector part of the quaternion, which is half
  /// of it.
  PoseGraph<Pose> graph;
  /// Whether the file has a VERTEX for the pose; identity where it has not (see ChainedPoses).
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

/// Beside the file and renamed. What is read back is equal to the last bit. Poses that are not `given` are left out.
void WriteG2o(const std::string& path, const G2oGraph<SE3>& graph);
void WriteG2o(const std::string& path, const G2oGraph<SE2>& graph);

}  // namespace plslam
