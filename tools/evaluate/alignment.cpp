#include "tools/evaluate/alignment.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace plslam {
namespace {

constexpr std::array<std::pair<std::string_view, Alignment>, 4> kNames{
    {{"none", Alignment::kNone}, {"first", Alignment::kFirst}, {"se3", Alignment::kSe3}, {"sim3", Alignment::kSim3}}};

// Below this share of the largest, a singular value of the cross covariance is rounding: positions on a line.
constexpr double kRankTolerance = 1e-10;

using Svd = Eigen::JacobiSVD<Eigen::Matrix3d>;

struct Moments {
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_truth = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();         // truth x estimate
  Eigen::Matrix3d orientations = Eigen::Matrix3d::Zero();  // mean of R_truth R_estimate^T
  double variance_estimate = 0.0;
};

Moments ComputeMoments(const PosePairs& pairs) {
  Moments m;
  const double n = static_cast<double>(pairs.size());
  for (const PosePair& pair : pairs) {
    m.mean_estimate += pair.estimate.translation() / n;
    m.mean_truth += pair.truth.translation() / n;
    m.orientations += pair.truth.R() * pair.estimate.R().transpose() / n;
  }
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d e = pair.estimate.translation() - m.mean_estimate;
    m.cross += (pair.truth.translation() - m.mean_truth) * e.transpose() / n;
    m.variance_estimate += e.squaredNorm() / n;
  }
  return m;
}

// The last axis flips where the best orthogonal matrix would be a reflection.
Eigen::Vector3d Signs(const Svd& svd) {
  return {1.0, 1.0, svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0};
}

Eigen::Matrix3d NearestRotation(const Svd& svd) {
  return svd.matrixU() * Signs(svd).asDiagonal() * svd.matrixV().transpose();
}

// Turns R about `axis`, which it leaves where it is, to agree best with `orientations`: the angle that maximises
// trace(Turn(angle) * R * orientations^T).
Eigen::Matrix3d TurnToOrientations(const Eigen::Matrix3d& R, const Eigen::Vector3d& axis,
                                   const Eigen::Matrix3d& orientations) {
  const Eigen::Matrix3d B = R * orientations.transpose();
  const double angle = std::atan2((Skew(axis) * B).trace(), B.trace() - axis.dot(B * axis));
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix() * R;
}

Similarity Umeyama(const PosePairs& pairs, bool with_scale) {
  const Moments m = ComputeMoments(pairs);
  const Svd svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& sigma = svd.singularValues();
  // Rounding of positions far from the origin must not pass for motion.
  const double extent = 1.0 + m.mean_estimate.squaredNorm() + m.mean_truth.squaredNorm();
  const bool still = sigma[0] <= 1e-24 * extent;
  Eigen::Matrix3d R = NearestRotation(svd);
  if (still) {
    R = NearestRotation(Svd(m.orientations, Eigen::ComputeFullU | Eigen::ComputeFullV));
  } else if (sigma[1] <= kRankTolerance * sigma[0]) {
    R = TurnToOrientations(R, svd.matrixU().col(0), m.orientations);
  }
  Similarity result;
  if (with_scale && !still) result.scale = sigma.dot(Signs(svd)) / m.variance_estimate;
  result.T_truth_estimate = SE3(R, m.mean_truth - result.scale * R * m.mean_estimate);
  return result;
}

}  // namespace

SE3 Similarity::Apply(const SE3& pose) const {
  return T_truth_estimate * SE3(pose.rotation(), scale * pose.translation());
}

Similarity Align(const PosePairs& pairs, Alignment alignment) {
  if (pairs.empty() || alignment == Alignment::kNone) return {};
  if (alignment == Alignment::kFirst) return {1.0, pairs[0].truth * pairs[0].estimate.Inverse()};
  return Umeyama(pairs, alignment == Alignment::kSim3);
}

std::string AlignmentName(Alignment alignment) {
  for (const auto& [name, value] : kNames) {
    if (value == alignment) return std::string(name);
  }
  throw std::logic_error("alignment without a name");
}

Alignment AlignmentFromName(std::string_view name) {
  for (const auto& [known, value] : kNames) {
    if (known == name) return value;
  }
  throw std::runtime_error(fmt::format("no alignment '{}' (none, first, se3, sim3)", name));
}

}  // namespace plslam
