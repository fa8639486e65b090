// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/g2o.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "core/errors/error_text.h"
#include "core/files/atomic_file.h"

namespace plslam::pose_graph {
namespace {

constexpr double kMaxNormError = 0.01;

/// Diagonal of the transform from the optimiser's error to the file's.
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
    row.Fail(fmt::format("the norm of the quaternion is {:.4g}; it must be within 1 % of 1", norm));
  }
  // A quaternion that is unit up to rounding stays unchanged when it is read again.
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

namespace {

void ExpectFields(const TextRow& row, size_t n) {
  if (row.fields.size() == n) return;
  row.Fail(fmt::format("{} has {} fields after it, and must have {}", row.fields[0], row.fields.size() - 1, n - 1));
}

/// Reads the rows of poses of one dimension (2D or 3D).
template <class Pose>
class Reader {
 public:
  using Rows = G2oRows<Pose>;
  static constexpr size_t kInformation = kPoseFreedom<Pose> * (kPoseFreedom<Pose> + 1) / 2;

  bool empty() const { return poses_.empty() && edges_.empty(); }
  bool has_edges() const { return !edges_.empty(); }
  bool Contains(int64_t id) const { return poses_.contains(id); }

  /// Returns false if the tag is not of this type.
  bool Take(const TextRow& row) {
    if (row.fields[0] == Rows::kVertex) {
      TakeVertex(row);
    } else if (row.fields[0] == Rows::kEdge) {
      TakeEdge(row);
    } else {
      return false;
    }
    return true;
  }

  G2oGraph<Pose> Graph(const std::set<int64_t>& fixed) && {
    G2oGraph<Pose> result;
    std::map<int64_t, int> places;
    for (const auto& [id, pose] : poses_) {
      places[id] = static_cast<int>(result.ids.size());
      result.ids.push_back(id);
      result.given.push_back(pose.has_value());
      result.graph.poses.push_back({pose.value_or(Pose()), fixed.contains(id)});
    }
    for (Edge& edge : edges_) {
      edge.motion.a = places.at(edge.a);
      edge.motion.b = places.at(edge.b);
      result.graph.edges.push_back(edge.motion);
    }
    return result;
  }

 private:
  struct Edge {
    int64_t a;
    int64_t b;
    PoseGraphMotion<Pose> motion;
  };

  void TakeVertex(const TextRow& row) {
    ExpectFields(row, 2 + Rows::kNumbers);
    const int64_t id = ReadG2oId(row, 1);
    std::optional<Pose>& pose = poses_[id];
    if (pose) row.Fail(fmt::format("vertex {} is defined twice", id));
    pose = Rows::Read(row, 2);
  }

  void TakeEdge(const TextRow& row) {
    ExpectFields(row, 3 + Rows::kNumbers + kInformation);
    Edge edge{ReadG2oId(row, 1), ReadG2oId(row, 2), {}};
    if (edge.a == edge.b) row.Fail(fmt::format("the edge joins vertex {} to itself", edge.a));
    edge.motion.T_a_b = Rows::Read(row, 3);
    edge.motion.information = ReadG2oInformation<Pose>(row, 3 + Rows::kNumbers);
    poses_.try_emplace(edge.a);
    poses_.try_emplace(edge.b);
    edges_.push_back(edge);
  }

  std::map<int64_t, std::optional<Pose>> poses_;
  std::vector<Edge> edges_;
};

class FileReader {
 public:
  void Take(const TextRow& row) {
    const std::string tag(row.fields[0]);
    if (tag == "FIX") {
      TakeFix(row);
    } else if (tag.starts_with("PARAMS_")) {
      ++skipped_[tag];
    } else if (!space_.Take(row) && !plane_.Take(row)) {
      row.Fail(
          fmt::format("'{}' is not one of VERTEX_SE3:QUAT, EDGE_SE3:QUAT, VERTEX_SE2, EDGE_SE2, FIX", Shown(tag)));
    }
    if (!space_.empty() && !plane_.empty()) row.Fail("a file cannot contain both 2D and 3D poses");
  }

  G2oFile File(const std::string& path) && {
    if (!space_.has_edges() && !plane_.has_edges()) throw std::runtime_error(path + ": has no edges");
    for (const auto& [id, line] : fixed_lines_) {
      if (space_.Contains(id) || plane_.Contains(id)) continue;
      throw std::runtime_error(
          fmt::format("{}:{}: FIX names vertex {}, which no other line defines", path, line, id));
    }
    std::set<int64_t> fixed;
    for (const auto& [id, line] : fixed_lines_) fixed.insert(id);
    if (space_.has_edges()) return {std::move(space_).Graph(fixed), skipped_};
    return {std::move(plane_).Graph(fixed), skipped_};
  }

 private:
  void TakeFix(const TextRow& row) {
    for (size_t i = 1; i < row.fields.size(); ++i) fixed_lines_.try_emplace(ReadG2oId(row, i), row.line);
  }

  Reader<SE3> space_;
  Reader<SE2> plane_;
  std::map<int64_t, int> fixed_lines_;
  std::map<std::string, int> skipped_;
};

template <class Pose>
void Write(const std::string& path, const G2oGraph<Pose>& graph) {
  using Rows = G2oRows<Pose>;
  std::string text;
  std::string fixes;
  for (size_t i = 0; i < graph.ids.size(); ++i) {
    const PoseGraphNode<Pose>& node = graph.graph.poses[i];
    if (graph.given[i]) text += fmt::format("{} {} {}\n", Rows::kVertex, graph.ids[i], Rows::Text(node.T_w_kf));
    if (node.fixed) fixes += fmt::format("FIX {}\n", graph.ids[i]);
  }
  text += fixes;
  for (const PoseGraphMotion<Pose>& edge : graph.graph.edges) {
    text += fmt::format("{} {} {} {}{}\n", Rows::kEdge, graph.ids[edge.a], graph.ids[edge.b], Rows::Text(edge.T_a_b),
                        G2oInformationText<Pose>(edge.information));
  }
  WriteFileAtomically(path, text);
}

}  // namespace

G2oFile ReadG2o(const std::string& path) {
  FileReader reader;
  ForEachRow(path, [&](const TextRow& row) { reader.Take(row); });
  return std::move(reader).File(path);
}

void WriteG2o(const std::string& path, const G2oGraph<SE3>& graph) { Write(path, graph); }
void WriteG2o(const std::string& path, const G2oGraph<SE2>& graph) { Write(path, graph); }

}  // namespace plslam::pose_graph
