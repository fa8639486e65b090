#include "viewer_headless/report/rigid_alignment.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace plslam {
namespace {

// Second to first singular value of the spread of positions: below, the rotation about their line is noise.
constexpr double kMinFlatness = 1e-3;

Eigen::Matrix3Xd Positions(const std::vector<SE3>& poses) {
  Eigen::Matrix3Xd positions(3, poses.size());
  for (size_t i = 0; i < poses.size(); ++i) positions.col(static_cast<Eigen::Index>(i)) = poses[i].translation();
  return positions;
}

bool AreOnALine(const Eigen::Matrix3Xd& positions) {
  const Eigen::Matrix3Xd centred = positions.colwise() - positions.rowwise().mean();
  const Eigen::Matrix3d scatter = centred * centred.transpose();
  const Eigen::Vector3d values = scatter.jacobiSvd().singularValues().cwiseSqrt();
  return values(1) < kMinFlatness * values(0) || values(0) <= 0.0;
}

}  // namespace

SE3 AlignPoses(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  if (a.empty()) return {};
  const Eigen::Matrix3Xd p_a = Positions(a), p_b = Positions(b);
  if (a.size() < 3 || AreOnALine(p_b)) return a.front() * b.front().Inverse();
  const Eigen::Matrix4d T = Eigen::umeyama(p_b, p_a, false);
  return SE3(Eigen::Matrix3d(T.topLeftCorner<3, 3>()), Eigen::Vector3d(T.topRightCorner<3, 1>()));
}

}  // namespace plslam
