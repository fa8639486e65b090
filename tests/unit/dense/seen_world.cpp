// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/dense/seen_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <Eigen/LU>

#include "core/geometry/rectifier.h"
#include "vo_process/options.h"
#include "vo_process/stereo/stereo_front_end.h"

namespace plslam::dense::test {
namespace {

double Distance(const synthetic::Quad& quad, const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 3, 2> edges;
  edges << quad.edge_s, quad.edge_t;
  Eigen::Vector2d st = (edges.transpose() * edges).inverse() * edges.transpose() * (p - quad.origin);
  st = st.cwiseMax(0.0).cwiseMin(1.0);
  return (quad.origin + edges * st - p).norm();
}

}  // namespace

double Quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<double> DistancesFrom(const synthetic::World& world, const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> distances;
  for (const Eigen::Vector3d& p : points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const synthetic::Quad& quad : world.quads()) nearest = std::min(nearest, Distance(quad, p));
    distances.push_back(nearest);
  }
  return distances;
}

double DoubledShare(const synthetic::World& world, const std::vector<Surface::Vertex>& vertices, double gap_m) {
  constexpr double kPlace_m = 0.1, kSame_m = 0.5, kSameNormal = 0.8;
  // Signed distances from a quad, by the quad, the place on it, and the side that the surface faces.
  std::map<std::tuple<size_t, int, int, bool>, std::vector<double>> layers;
  for (const Surface::Vertex& vertex : vertices) {
    const Eigen::Vector3d p = vertex.p.cast<double>();
    double nearest = kSame_m;
    std::tuple<size_t, int, int, bool> place;
    double signed_m = 0.0;
    for (size_t i = 0; i < world.quads().size(); ++i) {
      const synthetic::Quad& quad = world.quads()[i];
      const Eigen::Vector3d normal = quad.edge_s.cross(quad.edge_t).normalized();
      const double facing = normal.dot(vertex.normal.cast<double>());
      const double distance = Distance(quad, p);
      if (std::abs(facing) < kSameNormal || distance >= nearest) continue;
      nearest = distance;
      signed_m = normal.dot(p - quad.origin);
      const auto at = [&](const Eigen::Vector3d& edge) {
        return static_cast<int>(std::floor(edge.normalized().dot(p - quad.origin) / kPlace_m));
      };
      place = {i, at(quad.edge_s), at(quad.edge_t), facing > 0.0};
    }
    if (nearest < kSame_m) layers[place].push_back(signed_m);
  }
  int n_places = 0, n_doubled = 0;
  for (auto& [place, distances] : layers) {
    if (distances.size() < 4) continue;
    ++n_places;
    std::ranges::sort(distances);
    // A layer has two vertices at least.
    bool is_doubled = false;
    for (size_t i = 2; i + 1 < distances.size(); ++i) is_doubled |= distances[i] - distances[i - 1] > gap_m;
    n_doubled += is_doubled ? 1 : 0;
  }
  return n_places > 0 ? static_cast<double>(n_doubled) / n_places : 1.0;
}

SeenWorld::SeenWorld(const std::string& options, int step, double voxel_m)
    : simulator_(synthetic::ParseOptions(options)), step_(step), map_(voxel_m, 0.0) {
  vo::StereoFrontEnd front_end(simulator_.rig(), {});
  const Rectifier rectifier(simulator_.rig());
  for (int i = 0; i < simulator_.size(); i += step) {
    const StereoImages images = simulator_.Render(i);
    vo::StageTimer timer([] { return 0.0; });
    const StereoFeatures features = front_end.Process(images, timer);
    poses_[{1, i}] = simulator_.T_w_c(i);
    const DepthImage depth = MatchPair(rectifier.RectifyLeft(images.left), rectifier.RectifyRight(images.right),
                                       rectifier.left_mask(), rectifier.camera(), features);
    map_.Add({1, i}, depth, images.left, rectifier.camera(), poses_);
    CompareDepth(i, depth);
  }
  surface_ = ExtractSurface(map_.Merge(poses_, SE3()));
}

std::vector<Eigen::Vector3d> SeenWorld::Path() const {
  std::vector<Eigen::Vector3d> path;
  for (int i = 0; i < simulator_.size(); ++i) path.push_back(simulator_.T_w_c(i).translation());
  return path;
}

std::vector<double> SeenWorld::Errors(double range_m) const {
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < surface_.vertices.size(); i += 5) {
    const Eigen::Vector3d p = surface_.vertices[i].p.cast<double>();
    const bool is_near = std::ranges::any_of(
        poses_, [&](const auto& keyframe) { return (keyframe.second.translation() - p).norm() < range_m; });
    if (is_near) points.push_back(p);
  }
  return DistancesFrom(simulator_.world(), points);
}

double SeenWorld::Completeness(double range_m) const {
  const double cell_m = 1.5 * map_.voxel_m();
  using Cell = std::tuple<int, int, int>;
  const auto cell_of = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3i i = (p / cell_m).array().round().cast<int>();
    return Cell(i.x(), i.y(), i.z());
  };
  std::set<Cell> present, seen;
  for (const Surface::Vertex& vertex : surface_.vertices) present.insert(cell_of(vertex.p.cast<double>()));
  const StereoCamera camera = Rectifier(simulator_.rig()).camera();
  for (int i = 0; i < simulator_.size(); i += step_) {
    const std::vector<float> depth = simulator_.RenderDepth(i);
    for (int y = 4; y < camera.height_px; y += 8) {
      for (int x = 4; x < camera.width_px; x += 8) {
        const double z = depth[static_cast<size_t>(y * camera.width_px + x)];
        if (z <= 0.0 || z > range_m) continue;
        const Eigen::Vector3d p((x - camera.cx_px) / camera.f_px * z, (y - camera.cy_px) / camera.f_px * z, z);
        seen.insert(cell_of(simulator_.T_w_c(i) * p));
      }
    }
  }
  int n = 0;
  for (const auto& [i, j, k] : seen) {
    bool found = false;
    for (int d = 0; d < 27 && !found; ++d)
      found = present.contains({i + d % 3 - 1, j + d / 3 % 3 - 1, k + d / 9 - 1});
    n += found ? 1 : 0;
  }
  return n / static_cast<double>(seen.size());
}

void SeenWorld::CompareDepth(int frame, const DepthImage& depth) {
  const std::vector<float> truth = simulator_.RenderDepth(frame);
  for (int y = 0; y < depth.z_m.rows; y += 4) {
    for (int x = 0; x < depth.z_m.cols; x += 4) {
      const float z = depth.z_m.at<float>(y, x);
      const float true_z = truth[static_cast<size_t>(y * depth.z_m.cols + x)];
      if (z > 0.0F && true_z > 0.0F) normalised_.push_back(std::abs(z - true_z) / depth.sigma_m.at<float>(y, x));
    }
  }
}

}  // namespace plslam::dense::test
