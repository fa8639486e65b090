// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/inertial_chain.h"

#include <map>

#include "core/motion/robust.h"

namespace plslam {
namespace {

// Errors of real sensors that densities of a data sheet lack: vibration, scale, and stamps that are off.
constexpr double kNoiseFactor = 2.0;
constexpr double kVelocity_m_s = 0.002;
constexpr double kPosition_m = 0.0002;
// Information of a velocity that nothing determines.
constexpr double kAnyVelocity = 1e-6;
// Number of solutions in which the weights of the motions are found.
constexpr int kPasses = 3;
// Place of gravity among the states.
constexpr int kGravity = 0;

Matrix6d CovarianceOf(const InertialMotion& motion) {
  const Preintegration::Jacobians& jacobians = motion.sensed.jacobians();
  Eigen::Matrix<double, 6, 3> by_rate_bias;
  by_rate_bias << jacobians.v_rate, jacobians.p_rate;
  Vector6d others;
  others << Eigen::Vector3d::Constant(kVelocity_m_s), Eigen::Vector3d::Constant(kPosition_m);
  const double variance = motion.bias.rate_sigma_rad_s * motion.bias.rate_sigma_rad_s;
  Matrix6d covariance = kNoiseFactor * kNoiseFactor * motion.sensed.covariance().bottomRightCorner<6, 6>() +
                        variance * by_rate_bias * by_rate_bias.transpose();
  covariance.diagonal() += others.cwiseAbs2();
  return covariance;
}

/// Positions of the sensor at both poses, one minus the other, in w.
Eigen::Vector3d Translation(const AdjustedPose& a, const AdjustedPose& b, const Eigen::Vector3d& lever_m) {
  return b.view.t_w_c - a.view.t_w_c + (b.view.R_c_w.transpose() - a.view.R_c_w.transpose()) * lever_m;
}

}  // namespace

InertialChain::InertialChain(const BundleProblem& problem, std::vector<AdjustedPose>& poses) {
  std::vector<double> information;
  const auto append = [&information](double of_each) {
    information.insert(information.end(), 3, of_each);
    return static_cast<int>(information.size()) - 3;
  };
  append(0.0);  // gravity
  std::map<const AdjustedPose*, int> velocities;
  std::map<const AdjustedPose*, int> biases;  // of the chain that ends with the pose
  for (const InertialMotion& motion : problem.inertial_motions) {
    AdjustedPose& a = poses[static_cast<size_t>(motion.a)];
    AdjustedPose& b = poses[static_cast<size_t>(motion.b)];
    if (a.observations == 0 || b.observations == 0) continue;
    const Eigen::LLT<Matrix6d> root(CovarianceOf(motion));
    if (root.info() != Eigen::Success) continue;
    const Preintegration& sensed = motion.sensed;
    Link link{&a,
              &b,
              motion.T_c_imu,
              sensed.dt_s(),
              sensed.VelocityWith(motion.bias.mean),
              sensed.PositionWith(motion.bias.mean),
              root.matrixL().solve(Matrix6d::Identity()),
              {},
              {}};
    link.by_bias << sensed.jacobians().v_force, sensed.jacobians().p_force;
    link.by_bias = -link.whitening * link.by_bias;
    const auto chain = biases.find(&a);
    const double sigma = motion.bias.force_sigma_m_s2;
    const int bias = chain != biases.end() ? chain->second : append(1.0 / (sigma * sigma));
    biases[&b] = bias;
    for (const AdjustedPose* pose : {&a, &b}) {
      if (!velocities.contains(pose)) velocities[pose] = append(kAnyVelocity);
    }
    link.rows = {kGravity, velocities[&a], velocities[&b], bias};
    links_.push_back(link);
  }
  const auto n = static_cast<Eigen::Index>(information.size());
  prior_information_ = Eigen::Map<const Eigen::VectorXd>(information.data(), n).asDiagonal();
  prior_information_.block<3, 3>(kGravity, kGravity) = problem.gravity.covariance.inverse();
  expected_ = Eigen::VectorXd::Zero(n);
  expected_.segment<3>(kGravity) = problem.gravity.g_w_m_s2;
}

InertialChain::LinkNow InertialChain::AtCurrentPoses(const Link& link) {
  const Eigen::Matrix3d R_imu_w = link.T_c_imu.R().transpose() * link.a->view.R_c_w;
  const Eigen::Vector3d translation = Translation(*link.a, *link.b, link.T_c_imu.translation());
  const double t = link.t_s;
  LinkNow now;
  now.r0 << -link.dv_m_s, R_imu_w * translation - link.dp_m;
  now.r0 = link.whitening * now.r0;
  ByState by_gravity, by_va, by_vb;
  by_gravity << -t * R_imu_w, -0.5 * t * t * R_imu_w;
  by_va << -R_imu_w, -t * R_imu_w;
  by_vb << R_imu_w, Eigen::Matrix3d::Zero();
  now.by_state = {link.whitening * by_gravity, link.whitening * by_va, link.whitening * by_vb, link.by_bias};
  return now;
}

InertialChain::Residual InertialChain::LinkNow::At(const Link& link, const Eigen::VectorXd& states) const {
  Residual r = r0;
  for (size_t i = 0; i < by_state.size(); ++i) r.noalias() += by_state[i] * states.segment<3>(link.rows[i]);
  return r;
}

InertialChain::Solution InertialChain::Solve() const {
  Solution solution;
  for (const Link& link : links_) solution.links.push_back(AtCurrentPoses(link));
  for (int pass = 0; pass < kPasses; ++pass) {
    Eigen::MatrixXd H = prior_information_;
    Eigen::VectorXd g = prior_information_ * expected_;
    for (size_t k = 0; k < links_.size(); ++k) {
      const auto& rows = links_[k].rows;
      const LinkNow& now = solution.links[k];
      for (size_t i = 0; i < rows.size(); ++i) {
        const ByState weighted = now.weight * now.by_state[i];
        g.segment<3>(rows[i]).noalias() -= weighted.transpose() * now.r0;
        for (size_t j = 0; j < rows.size(); ++j)
          H.block<3, 3>(rows[i], rows[j]).noalias() += weighted.transpose() * now.by_state[j];
      }
    }
    solution.information.compute(H);
    solution.states = solution.information.solve(g);
    const Eigen::VectorXd off = solution.states - expected_;
    solution.loss = off.dot(prior_information_ * off);
    for (size_t k = 0; k < links_.size(); ++k) {
      const double squared = solution.links[k].At(links_[k], solution.states).squaredNorm();
      solution.loss += PseudoHuberLoss(squared, kDelta);
      if (pass + 1 < kPasses) solution.links[k].weight = PseudoHuberWeight(squared, kDelta);
    }
  }
  return solution;
}

double InertialChain::Loss() const { return links_.empty() ? 0.0 : Solve().loss; }

std::array<Matrix6d, 2> InertialChain::ByPoses(const Link& link, const Eigen::VectorXd& states) {
  const CameraView &a = link.a->view, &b = link.b->view;
  const Eigen::Vector3d& lever_m = link.T_c_imu.translation();
  const Eigen::Matrix3d R_imu_c = link.T_c_imu.R().transpose();
  const Eigen::Matrix3d R_imu_w = R_imu_c * a.R_c_w;
  const Eigen::Vector3d g = states.segment<3>(link.rows[0]);
  const Eigen::Vector3d va = states.segment<3>(link.rows[1]), vb = states.segment<3>(link.rows[2]);
  const double t = link.t_s;
  const Eigen::Vector3d velocity = R_imu_w * (vb - va - t * g);
  const Eigen::Vector3d position = R_imu_w * (Translation(*link.a, *link.b, lever_m) - t * va - 0.5 * t * t * g);
  Matrix6d by_a = Matrix6d::Zero(), by_b = Matrix6d::Zero();
  by_a.block<3, 3>(3, 0) = -R_imu_w;
  by_a.block<3, 3>(0, 3) = Skew(velocity) * R_imu_c * a.turn;
  by_a.block<3, 3>(3, 3) = (Skew(position) * R_imu_c + R_imu_c * Skew(lever_m)) * a.turn;
  by_b.block<3, 3>(3, 0) = R_imu_w;
  by_b.block<3, 3>(3, 3) = -R_imu_w * b.R_c_w.transpose() * Skew(lever_m) * b.turn;
  return {link.whitening * by_a, link.whitening * by_b};
}

double InertialChain::Linearise(PoseSystem& system) const {
  if (links_.empty()) return 0.0;
  const Solution solution = Solve();
  // Blocks of each free pose and the states.
  std::map<int, Eigen::MatrixXd> couplings;
  for (size_t k = 0; k < links_.size(); ++k) {
    const Link& link = links_[k];
    const LinkNow& now = solution.links[k];
    const Residual r = now.At(link, solution.states);
    const std::array<int, 2> poses{link.a->column, link.b->column};
    const std::array<Matrix6d, 2> by = ByPoses(link, solution.states);
    for (size_t i = 0; i < poses.size(); ++i) {
      if (poses[i] < 0) continue;
      const Matrix6d weighted = now.weight * by[i];
      system.Diagonal(poses[i]).noalias() += weighted.transpose() * by[i];
      system.Gradient(poses[i]).noalias() += weighted.transpose() * r;
      Eigen::MatrixXd& coupling =
          couplings.try_emplace(poses[i], Eigen::MatrixXd::Zero(6, solution.states.size())).first->second;
      for (size_t j = 0; j < link.rows.size(); ++j)
        coupling.middleCols<3>(link.rows[j]).noalias() += weighted.transpose() * now.by_state[j];
    }
    if (poses[0] < 0 || poses[1] < 0) continue;
    const size_t earlier = poses[0] < poses[1] ? 0 : 1;
    system.Below(poses[earlier], poses[1 - earlier]).noalias() +=
        now.weight * by[1 - earlier].transpose() * by[earlier];
  }
  for (const auto& [later, of_later] : couplings) {
    const Eigen::MatrixXd half = solution.information.solve(of_later.transpose()).transpose();
    for (const auto& [earlier, of_earlier] : couplings) {
      if (earlier == later) {
        system.Diagonal(later).noalias() -= half * of_later.transpose();
        break;
      }
      system.Below(earlier, later).noalias() -= half * of_earlier.transpose();
    }
  }
  return solution.loss;
}

void InertialChain::HoldPoses() {
  for (const Link& link : links_) link.a->constant = link.b->constant = true;
}

}  // namespace plslam
