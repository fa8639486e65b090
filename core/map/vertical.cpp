// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/vertical.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/geometry/angle.h"
#include "core/geometry/hypot.h"
#include "core/geometry/se3.h"

namespace plslam {
namespace {

/// Lines within this angle of the cameras' mean up direction are candidates.
constexpr double kNear_rad = 45.0 * kRadPerDeg;
/// Lower bound on the sigma of a line's direction: buildings and maps are no more accurate.
constexpr double kLeastSigma_rad = 1.0 * kRadPerDeg;
/// Reach of a vote, and of the weights of the final mean; angle within which a direction agrees with that mean, and the
/// least number that do.
struct Agreement {
  double wide_rad;
  double narrow_rad;
  double agreeing_rad;
  int64_t least;
};
constexpr Agreement kOfLines{4.0 * kRadPerDeg, 2.0 * kRadPerDeg, 3.0 * kRadPerDeg, 8};
constexpr Agreement kOfNormals{8.0 * kRadPerDeg, 5.0 * kRadPerDeg, 8.0 * kRadPerDeg, 200};
constexpr int kMeans = 10;
constexpr size_t kMaxCandidates = 300;
constexpr size_t kMaxNormals = 3000;
constexpr double kLeastShare = 0.2;
/// Segments that an edge of the scene has in the map, about.
constexpr double kLinesOfAnEdge = 4.0;
/// Sigma of the vertical of buildings.
constexpr double kBuilding_rad = 0.1 * kRadPerDeg;
/// Sigma up to which gravity decides alone.
constexpr double kKnown_rad = 1.0 * kRadPerDeg;

struct Direction {
  Eigen::Vector3d d;
  double weight;
};

/// Variance of the direction of a line about each axis across it, in rad^2.
double Variance(const MapLine& line, const Eigen::Vector3d& d, double length_m) {
  const Eigen::Matrix3d sum = line.covariance_p.matrix() + line.covariance_q.matrix();
  return std::max(0.0, 0.5 * (sum.trace() - d.dot(sum * d))) / (length_m * length_m);
}

std::vector<Direction> DirectionsNear(const Map& map, const Eigen::Vector3d& about_w) {
  std::vector<Direction> directions;
  for (const auto& [id, line] : map.lines()) {
    const Eigen::Vector3d v = line.segment_w.q - line.segment_w.p;
    const double length_m = v.norm();
    if (!std::isfinite(length_m) || length_m <= 0.0) continue;
    const Eigen::Vector3d d = v / (v.dot(about_w) < 0.0 ? -length_m : length_m);
    const double weight = 1.0 / (kLeastSigma_rad * kLeastSigma_rad + Variance(line, d, length_m));
    if (std::isfinite(weight) && AngleBetween(d, about_w) < kNear_rad) directions.push_back({d, weight});
  }
  return directions;
}

/// Tukey's weight by the distance of two unit vectors, which approximates their angle; cheap, because all pairs vote.
double TukeyWeight(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double reach_rad) {
  const double rest = 1.0 - (a - b).squaredNorm() / (reach_rad * reach_rad);
  return rest > 0.0 ? rest * rest : 0.0;
}

double Votes(const std::vector<Direction>& directions, const Eigen::Vector3d& up, double reach_rad) {
  double votes = 0.0;
  for (const Direction& direction : directions) {
    votes += direction.weight * TukeyWeight(direction.d, up, reach_rad);
  }
  return votes;
}

Eigen::Vector3d MostVoted(const std::vector<Direction>& directions, double reach_rad) {
  const size_t step = (directions.size() + kMaxCandidates - 1) / kMaxCandidates;
  Eigen::Vector3d best = directions.front().d;
  double most = -1.0;
  for (size_t i = 0; i < directions.size(); i += step) {
    const double votes = Votes(directions, directions[i].d, reach_rad);
    if (votes <= most) continue;
    most = votes;
    best = directions[i].d;
  }
  return best;
}

Eigen::Vector3d Refine(const std::vector<Direction>& directions, Eigen::Vector3d up, const Agreement& agreement) {
  for (int i = 0; i < kMeans; ++i) {
    const double reach = i < kMeans / 2 ? agreement.wide_rad : agreement.narrow_rad;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Direction& direction : directions) {
      sum += direction.weight * TukeyWeight(direction.d, up, reach) * direction.d;
    }
    // The narrow reach may contain no line.
    if (sum.norm() > 0.0) up = sum.normalized();
  }
  return up;
}

/// The direction on which most of them agree.
struct Common {
  Eigen::Vector3d up;
  int64_t n = 0;               ///< that agree
  double variance_rad2 = 0.0;  ///< weighted mean square of their angles to it
};

std::optional<Common> CommonDirection(const std::vector<Direction>& directions, const Agreement& agreement) {
  if (directions.empty()) return std::nullopt;
  Common common;
  common.up = Refine(directions, MostVoted(directions, agreement.wide_rad), agreement);
  double all = 0.0, agreeing = 0.0, squares = 0.0;
  for (const Direction& direction : directions) {
    all += direction.weight;
    const double angle = AngleBetween(direction.d, common.up);
    if (angle > agreement.agreeing_rad) continue;
    agreeing += direction.weight;
    squares += direction.weight * angle * angle;
    ++common.n;
  }
  if (common.n < agreement.least || agreeing < kLeastShare * all) return std::nullopt;
  common.variance_rad2 = squares / agreeing;
  return common;
}

}  // namespace

Eigen::Vector3d MeanUpOfCameras(const Map& map, const Eigen::Vector3d& up_c) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [id, keyframe] : map.keyframes()) sum += keyframe.T_w_kf.rotation() * up_c;
  const double least = 0.1 * static_cast<double>(map.keyframes().size());
  return sum.norm() > least ? sum.normalized() : up_c;
}

std::optional<Vertical> VerticalFromLines(const Map& map, const Eigen::Vector3d& about_w) {
  const std::optional<Common> common = CommonDirection(DirectionsNear(map, about_w), kOfLines);
  if (!common) return std::nullopt;
  // Half the mean square, for each of two angles; a line's neighbours on the same edge have the same error.
  const auto n = static_cast<double>(common->n) / kLinesOfAnEdge;
  const double sigma_rad = Hypot(std::sqrt(0.5 * common->variance_rad2 / n), kBuilding_rad);
  return Vertical{common->up, VerticalSource::kLines, sigma_rad, common->n};
}

std::optional<Vertical> VerticalFromNormals(std::span<const Eigen::Vector3d> normals_w,
                                            const Eigen::Vector3d& about_w) {
  std::vector<Direction> directions;
  const size_t step = (normals_w.size() + kMaxNormals - 1) / kMaxNormals;
  for (size_t i = 0; i < normals_w.size(); i += step) {
    if (AngleBetween(normals_w[i], about_w) < kNear_rad) directions.push_back({normals_w[i], 1.0});
  }
  const std::optional<Common> common = CommonDirection(directions, kOfNormals);
  if (!common) return std::nullopt;
  return Vertical{common->up, VerticalSource::kSurfaces, 0.0, common->n};
}

std::optional<Vertical> VerticalFromGravity(const Map& map) {
  std::vector<Direction> directions;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (!keyframe.up) continue;
    const double weight = 1.0 / (keyframe.up->sigma_rad * keyframe.up->sigma_rad);
    directions.push_back({keyframe.T_w_kf.rotation() * keyframe.up->direction, weight});
    sum += weight * directions.back().d;
    weights += weight;
  }
  if (directions.empty() || sum.norm() < 0.5 * weights) return std::nullopt;
  Vertical vertical{sum.normalized(), VerticalSource::kGravity, 0.0, static_cast<int64_t>(directions.size())};
  const auto n = static_cast<double>(directions.size());
  double chi2 = 0.0;
  for (const Direction& direction : directions) {
    const double angle = AngleBetween(direction.d, vertical.up_w);
    chi2 += direction.weight * angle * angle;
  }
  vertical.sigma_rad = std::sqrt(n / weights * std::max(1.0, 0.5 * chi2 / n));
  return vertical;
}

Vertical VerticalOf(const Map& map) {
  const std::optional<Vertical> gravity = VerticalFromGravity(map);
  if (gravity && gravity->sigma_rad < kKnown_rad) return *gravity;
  const Vertical rough = gravity.value_or(Vertical{MeanUpOfCameras(map)});
  return VerticalFromLines(map, rough.up_w).value_or(rough);
}

Vertical VerticalOf(const Map& map, const std::vector<double>& up_c) {
  if (up_c.empty()) return VerticalOf(map);
  const bool are_three = up_c.size() == 3;
  const Eigen::Vector3d direction = are_three ? Eigen::Vector3d(up_c[0], up_c[1], up_c[2]) : Eigen::Vector3d::Zero();
  if (!(direction.norm() > 0.0 && std::isfinite(direction.norm())))
    throw std::invalid_argument(
        "needs three numbers that are not all zero: right, down and ahead in the camera's image");
  return {MeanUpOfCameras(map, direction.normalized()), VerticalSource::kGiven};
}

Eigen::Quaterniond LevelRotation(const Eigen::Vector3d& up_w) {
  return Eigen::Quaterniond::FromTwoVectors(up_w, -Eigen::Vector3d::UnitY());
}

}  // namespace plslam
