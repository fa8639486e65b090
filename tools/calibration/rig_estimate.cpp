// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/rig_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "core/geometry/distortion.h"
#include "core/motion/robust.h"
#include "tools/calibration/coverage.h"

namespace plslam::calibration {
namespace {

constexpr int kMinPairs = 10;
constexpr double kHuber_px = 1.0;
/// Corners farther away than this many standard deviations are outliers.
constexpr double kOutlierSigmas = 5.0;
/// A detector is never much better than this.
constexpr double kLeastNoise_px = 0.02;
/// Assumed noise of a corner before it is estimated.
constexpr double kUsualNoise_px = 0.1;

/// Prior of a coefficient; `index` counts from fx.
struct Prior {
  std::string_view model;
  int index;
  double mean;
  double sigma;
};
constexpr std::array kPriors = {Prior{lens_model::kRational, 9, 0.0, 0.5}, Prior{lens_model::kRational, 10, 0.0, 0.5},
                                Prior{lens_model::kRational, 11, 0.0, 0.5},
                                Prior{lens_model::kDoubleSphere, 4, -0.1, 0.2},
                                Prior{lens_model::kDoubleSphere, 5, 0.55, 0.2}};

using Pose = std::array<double, 6>;  ///< angle and axis, then translation: T_camera_board or T_right_left
using Lens = std::vector<double>;    ///< fx fy cx cy and coefficients

SE3 ToSE3(const Pose& p) { return {ExpSO3({p[0], p[1], p[2]}), Eigen::Vector3d(p[3], p[4], p[5])}; }

Pose ToPose(const SE3& T) {
  const Eigen::AngleAxisd turn(T.rotation());
  const Eigen::Vector3d r = turn.angle() * turn.axis();
  return {r.x(), r.y(), r.z(), T.translation().x(), T.translation().y(), T.translation().z()};
}

CameraCalibration ToCamera(const Lens& lens, const std::string& model, const ImageSize& size) {
  CameraCalibration camera;
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  camera.model = model;
  camera.fx_px = lens[0];
  camera.fy_px = lens[1];
  camera.cx_px = lens[2];
  camera.cy_px = lens[3];
  camera.distortion.assign(lens.begin() + 4, lens.end());
  return camera;
}

/// A corner in pixels as a camera sees it. Blocks: its lens, T_left_board, and for the right camera T_right_left.
struct CornerCost {
  std::string model;
  Eigen::Vector2d corner_m, pixel;

  template <typename T>
  bool Project(const T* lens, const T* p, T* residual) const {
    T seen[2];
    if (!ProjectLens(model, lens, p, seen)) return false;
    residual[0] = seen[0] - pixel.x();
    residual[1] = seen[1] - pixel.y();
    return true;
  }
  template <typename T>
  static void Move(const T* pose, const T* p, T* moved) {
    ceres::AngleAxisRotatePoint(pose, p, moved);
    for (int i = 0; i < 3; ++i) moved[i] += pose[3 + i];
  }
  template <typename T>
  bool operator()(T const* const* blocks, T* residual) const {
    const T on_board[3] = {T(corner_m.x()), T(corner_m.y()), T(0.0)};
    T p[3], q[3];
    Move(blocks[1], on_board, p);
    if (!is_right) return Project(blocks[0], p, residual);
    Move(blocks[2], p, q);
    return Project(blocks[0], q, residual);
  }
  bool is_right = false;
};

struct PriorCost {
  int index;
  double mean, sigma;
  template <typename T>
  bool operator()(T const* const* blocks, T* residual) const {
    residual[0] = (blocks[0][index] - mean) / sigma;
    return true;
  }
};

/// One coordinate pair that takes part or not.
struct Corner {
  size_t pair;
  bool is_right;
  Eigen::Vector2d corner_m, pixel;
  bool used = true;
};

struct State {
  Lens left, right;
  Pose T_right_left{};
  std::vector<Pose> T_left_board;
};

class Problem {
 public:
  Problem(std::string model, std::vector<Corner> corners) : model_(std::move(model)), corners_(std::move(corners)) {}
  std::vector<Corner>& corners() { return corners_; }

  /// Sets the standard deviation of a coordinate of a corner, which determines the weight of priors.
  void set_noise_px(double noise_px) { noise_px_ = noise_px; }

  /// Minimises; both lenses, the rig and the poses move.
  void Solve(State* state, bool robust) {
    ceres::Problem problem;
    Build(state, robust, &problem);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-10;
    options.logging_type = ceres::SILENT;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (Pose& pose : state->T_left_board) {
      if (problem.HasParameterBlock(pose.data())) ordering->AddElementToGroup(pose.data(), 0);
    }
    for (double* block : {state->left.data(), state->right.data(), state->T_right_left.data()}) {
      if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);
    }
    options.linear_solver_ordering = ordering;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable())
      throw std::runtime_error("the calibration does not converge: " + summary.message);
  }

  std::vector<double> Errors(const State& state) const {
    std::vector<double> errors;
    for (const Corner& corner : corners_) {
      const CornerCost cost{model_, corner.corner_m, corner.pixel, corner.is_right};
      const double* blocks[3] = {corner.is_right ? state.right.data() : state.left.data(),
                                 state.T_left_board[corner.pair].data(), state.T_right_left.data()};
      double residual[2];
      errors.push_back(cost(blocks, residual) ? std::hypot(residual[0], residual[1]) : 1e6);
    }
    return errors;
  }

  /// Covariance of left lens, right lens and T_right_left, in this order.
  Eigen::MatrixXd Covariance(State* state) {
    ceres::Problem problem;
    Build(state, false, &problem);
    ceres::Covariance covariance(ceres::Covariance::Options{});
    const std::vector<const double*> blocks{state->left.data(), state->right.data(), state->T_right_left.data()};
    if (!covariance.Compute(blocks, &problem)) {
      throw std::runtime_error(
          fmt::format("the pictures do not determine the coefficients of --model {}: tilt the board more, or use a "
                      "model with fewer",
                      model_));
    }
    const auto n = static_cast<Eigen::Index>(state->left.size() + state->right.size() + 6);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> all(n, n);
    covariance.GetCovarianceMatrix(blocks, all.data());
    return all;
  }

 private:
  void Build(State* state, bool robust, ceres::Problem* problem) const {
    for (const Corner& corner : corners_) {
      if (!corner.used) continue;
      auto* cost = new ceres::DynamicAutoDiffCostFunction<CornerCost, 6>(  // NOLINT: Ceres owns it.
          new CornerCost{model_, corner.corner_m, corner.pixel, corner.is_right});
      Lens& lens = corner.is_right ? state->right : state->left;
      cost->AddParameterBlock(static_cast<int>(lens.size()));
      cost->AddParameterBlock(6);
      cost->SetNumResiduals(2);
      std::vector<double*> blocks{lens.data(), state->T_left_board[corner.pair].data()};
      if (corner.is_right) {
        cost->AddParameterBlock(6);
        blocks.push_back(state->T_right_left.data());
      }
      ceres::LossFunction* huber = robust ? new ceres::HuberLoss(kHuber_px) : nullptr;                  // NOLINT
      auto* loss = new ceres::ScaledLoss(huber, 1.0 / (noise_px_ * noise_px_), ceres::TAKE_OWNERSHIP);  // NOLINT
      problem->AddResidualBlock(cost, loss, blocks);
    }
    for (Lens* lens : {&state->left, &state->right}) {
      if (problem->HasParameterBlock(lens->data())) AddPriors(lens, problem);
    }
  }

  void AddPriors(Lens* lens, ceres::Problem* problem) const {
    for (const Prior& prior : kPriors) {
      if (prior.model != model_) continue;
      auto* cost = new ceres::DynamicAutoDiffCostFunction<PriorCost, 6>(  // NOLINT
          new PriorCost{prior.index, prior.mean, prior.sigma});
      cost->AddParameterBlock(static_cast<int>(lens->size()));
      cost->SetNumResiduals(1);
      problem->AddResidualBlock(cost, nullptr, std::vector<double*>{lens->data()});
    }
  }

  std::string model_;
  std::vector<Corner> corners_;
  double noise_px_ = kUsualNoise_px;
};

std::vector<Corner> CornersOf(const Board& board, const BoardView& view, size_t pair, bool is_right) {
  const std::vector<Eigen::Vector2d> on_board = BoardCorners(board);
  std::vector<Corner> corners;
  for (size_t i = 0; i < view.corners.size(); ++i) {
    corners.push_back({pair, is_right, on_board[static_cast<size_t>(view.corners[i])], view.pixels[i]});
  }
  return corners;
}

/// Returns the pose of the board, from corners and an approximately known lens; nullopt if too few rays can be
/// computed.
std::optional<SE3> BoardPose(const std::vector<Corner>& corners, const CameraCalibration& camera) {
  const Distortion distortion(camera);
  std::vector<cv::Point3d> on_board;
  std::vector<cv::Point2d> rays;
  for (const Corner& corner : corners) {
    const auto ray = distortion.Undistort(
        {(corner.pixel.x() - camera.cx_px) / camera.fx_px, (corner.pixel.y() - camera.cy_px) / camera.fy_px});
    if (!ray) continue;
    on_board.emplace_back(corner.corner_m.x(), corner.corner_m.y(), 0.0);
    rays.emplace_back(ray->x(), ray->y());
  }
  if (rays.size() < 6) return std::nullopt;
  cv::Vec3d turn, t;
  const cv::Matx33d identity = cv::Matx33d::eye();
  if (!cv::solvePnP(on_board, rays, identity, cv::noArray(), turn, t, false, cv::SOLVEPNP_IPPE)) return std::nullopt;
  cv::solvePnPRefineLM(on_board, rays, identity, cv::noArray(), turn, t);
  return ToSE3({turn[0], turn[1], turn[2], t[0], t[1], t[2]});
}

/// A lens without distortion, of the focal length that makes the homographies of the boards most like views of a
/// plane (Zhang's start).
Lens StartLens(const std::vector<std::vector<Corner>>& views, const std::string& model, const ImageSize& size) {
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const std::vector<Corner>& view : views) {
    if (view.size() < 8) continue;
    on_board.emplace_back();
    pixels.emplace_back();
    for (const Corner& corner : view) {
      on_board.back().emplace_back(static_cast<float>(corner.corner_m.x()), static_cast<float>(corner.corner_m.y()),
                                   0.0F);
      pixels.back().emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
    }
  }
  const cv::Mat K = cv::initCameraMatrix2D(on_board, pixels, {size.width_px, size.height_px}, 1.0);
  double f = K.at<double>(0, 0);
  if (!(f > 0.2 * size.width_px && f < 20.0 * size.width_px)) f = size.width_px;
  Lens lens{f, f, 0.5 * (size.width_px - 1.0), 0.5 * (size.height_px - 1.0)};
  lens.resize(4 + FindLensModel(model)->max_coefficients, 0.0);
  for (const Prior& prior : kPriors) {
    if (prior.model == model) lens[static_cast<size_t>(prior.index)] = prior.mean;
  }
  // The homographies determine the scale in the centre of the image.
  const double scale = FocalInCentre_px(ToCamera(lens, model, size)) / f;
  lens[0] /= scale;
  lens[1] /= scale;
  return lens;
}

double MedianOf(std::vector<double> values) { return Median(values); }

/// A camera by itself: its lens, and poses of the boards it sees.
struct SingleCamera {
  Lens lens;
  std::vector<std::optional<SE3>> T_camera_board;
  double median_error_px = 0.0;
};

SingleCamera CalibrateAlone(const std::vector<std::vector<Corner>>& views, const std::string& model,
                            const ImageSize& size) {
  SingleCamera camera;
  State state;
  state.left = StartLens(views, model, size);
  state.T_left_board.resize(views.size());
  std::vector<Corner> corners;
  camera.T_camera_board.resize(views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    camera.T_camera_board[i] = BoardPose(views[i], ToCamera(state.left, model, size));
    if (!camera.T_camera_board[i]) continue;
    state.T_left_board[i] = ToPose(*camera.T_camera_board[i]);
    for (Corner corner : views[i]) {
      corner.is_right = false;
      corners.push_back(corner);
    }
  }
  Problem problem(model, corners);
  problem.Solve(&state, true);
  camera.lens = state.left;
  for (size_t i = 0; i < views.size(); ++i) {
    if (camera.T_camera_board[i]) camera.T_camera_board[i] = ToSE3(state.T_left_board[i]);
  }
  camera.median_error_px = MedianOf(problem.Errors(state));
  return camera;
}

/// Returns the pose of the right camera, each coordinate the median over the pairs.
SE3 MedianRig(const std::vector<SE3>& T_right_left) {
  Vector6d middle = Vector6d::Zero();
  for (int i = 0; i < 6; ++i) {
    std::vector<double> values;
    values.reserve(T_right_left.size());
    for (const SE3& T : T_right_left) values.push_back(ToPose(T)[static_cast<size_t>(i)]);
    middle[i] = MedianOf(values);
  }
  return ToSE3({middle[0], middle[1], middle[2], middle[3], middle[4], middle[5]});
}

/// Returns the error in pixels of a pair's right view, with the pose of the board from the left view.
double PairError_px(const std::vector<Corner>& right_view, const Lens& lens, const std::string& model,
                    const SE3& T_right_board) {
  std::vector<double> errors;
  for (const Corner& corner : right_view) {
    const Eigen::Vector3d p = T_right_board * Eigen::Vector3d(corner.corner_m.x(), corner.corner_m.y(), 0.0);
    double pixel[2];
    errors.push_back(ProjectLens(model, lens.data(), p.data(), pixel)
                         ? std::hypot(pixel[0] - corner.pixel.x(), pixel[1] - corner.pixel.y())
                         : 1e6);
  }
  return MedianOf(errors);
}

}  // namespace

BoardView NumberedLike(const Board& board, const BoardView& left, BoardView right) {
  if (board.kind != Board::Kind::kChess || left.pixels.empty() || right.pixels.empty()) return right;
  const Eigen::Vector2d a = left.pixels.back() - left.pixels.front(), b = right.pixels.back() - right.pixels.front();
  if (a.dot(b) < 0.0) std::reverse(right.pixels.begin(), right.pixels.end());
  return right;
}

std::vector<double> LensParameters(const CameraCalibration& camera) {
  std::vector<double> all{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
  all.insert(all.end(), camera.distortion.begin(), camera.distortion.end());
  return all;
}

double FocalInCentre_px(const CameraCalibration& camera) { return camera.fx_px * Distortion(camera).CentreScale(); }

double FocalInCentreSigma_px(const CameraCalibration& camera, const Eigen::MatrixXd& covariance) {
  Eigen::RowVectorXd J = Eigen::RowVectorXd::Zero(covariance.cols());
  J[0] = Distortion(camera).CentreScale();
  // The focal length in the centre is f / (1 + xi).
  if (camera.model == lens_model::kDoubleSphere) J[4] = -J[0] * FocalInCentre_px(camera);
  return std::sqrt((J * covariance * J.transpose())(0, 0));
}

std::optional<Eigen::MatrixXd> PixelJacobian(const CameraCalibration& camera, const Eigen::Vector2d& xy) {
  const Eigen::Vector3d ray = xy.homogeneous();
  const std::vector<double> parameters = LensParameters(camera);
  Eigen::MatrixXd J(2, static_cast<Eigen::Index>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    const double step = 1e-6 * std::max(1.0, std::abs(parameters[i]));
    Eigen::Vector2d pixels[2];
    for (const int side : {0, 1}) {
      std::vector<double> moved = parameters;
      moved[i] += side == 0 ? -step : step;
      if (!ProjectLens(camera.model, moved.data(), ray.data(), pixels[side].data())) return std::nullopt;
    }
    J.col(static_cast<Eigen::Index>(i)) = (pixels[1] - pixels[0]) / (2.0 * step);
  }
  return J;
}

double PixelSigma_px(const CameraCalibration& camera, const Eigen::MatrixXd& covariance) {
  constexpr int kCells = 8;
  const Distortion distortion(camera);
  double largest = 0.0;
  for (int i = 0; i <= kCells; ++i) {
    for (int k = 0; k <= kCells; ++k) {
      const Eigen::Vector2d pixel((camera.width_px - 1.0) * i / kCells, (camera.height_px - 1.0) * k / kCells);
      const auto xy = distortion.Undistort(
          {(pixel.x() - camera.cx_px) / camera.fx_px, (pixel.y() - camera.cy_px) / camera.fy_px});
      if (!xy) continue;
      const auto J = PixelJacobian(camera, *xy);
      if (J) largest = std::max(largest, (*J * covariance * J->transpose()).diagonal().maxCoeff());
    }
  }
  return std::sqrt(largest);
}

RigEstimate EstimateRig(const Board& board, const std::vector<BoardPair>& pairs, const ImageSize& size,
                        const std::string& model) {
  std::vector<std::vector<Corner>> left_views, right_views;
  int n_both = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    left_views.push_back(CornersOf(board, pairs[i].left, i, false));
    right_views.push_back(CornersOf(board, NumberedLike(board, pairs[i].left, pairs[i].right), i, true));
    n_both += !left_views[i].empty() && !right_views[i].empty() ? 1 : 0;
  }
  if (n_both < kMinPairs) {
    throw std::runtime_error(fmt::format(
        "the board {} is seen by both cameras in {} of {} pairs, at least {} are needed (30 or more are good)",
        BoardText(board), n_both, pairs.size(), kMinPairs));
  }
  const SingleCamera left = CalibrateAlone(left_views, model, size), right = CalibrateAlone(right_views, model, size);

  std::vector<SE3> relative;
  std::vector<size_t> of_pair;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (!left.T_camera_board[i] || !right.T_camera_board[i]) continue;
    relative.push_back(*right.T_camera_board[i] * left.T_camera_board[i]->Inverse());
    of_pair.push_back(i);
  }
  const SE3 T_right_left = MedianRig(relative);
  const Eigen::Vector3d right_in_left = T_right_left.Inverse().translation();
  // Rejects pairs that contradict the others: 5 px and ten times the error of a camera alone are no noise.
  const double bound_px = std::max(5.0, 10.0 * std::max(left.median_error_px, right.median_error_px));
  RigEstimate estimate;
  std::vector<bool> apart(pairs.size(), false);
  for (const size_t i : of_pair) {
    const SE3 T_right_board = T_right_left * *left.T_camera_board[i];
    apart[i] = PairError_px(right_views[i], right.lens, model, T_right_board) > bound_px;
    if (apart[i]) estimate.left_out_pairs.push_back(pairs[i].name);
  }
  if (5 * estimate.left_out_pairs.size() > of_pair.size()) {
    throw std::runtime_error(fmt::format(
        "left and right pictures do not match: in {} of {} pairs (for example {}) the board is at another position "
        "in the right picture than in the left one; were they taken at the same time, and is a file missing?",
        estimate.left_out_pairs.size(), of_pair.size(), estimate.left_out_pairs.front()));
  }
  if (right_in_left.x() < 0.0 && std::abs(right_in_left.x()) >= std::abs(right_in_left.y())) {
    throw std::runtime_error(fmt::format(
        "left and right pictures are exchanged: the right camera would be {:.4f} m to the left of the left one",
        -right_in_left.x()));
  }

  State state{left.lens, right.lens, ToPose(T_right_left), std::vector<Pose>(pairs.size())};
  std::vector<Corner> corners;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (apart[i] || (!left.T_camera_board[i] && !right.T_camera_board[i])) continue;
    const SE3 T_left_board =
        left.T_camera_board[i] ? *left.T_camera_board[i] : T_right_left.Inverse() * *right.T_camera_board[i];
    state.T_left_board[i] = ToPose(T_left_board);
    const Eigen::Vector3d normal = T_left_board.rotation() * Eigen::Vector3d::UnitZ();
    estimate.max_tilt_deg =
        std::max(estimate.max_tilt_deg, std::acos(std::min(1.0, std::abs(normal.z()))) / kRadPerDeg);
    if (left.T_camera_board[i]) corners.insert(corners.end(), left_views[i].begin(), left_views[i].end());
    if (right.T_camera_board[i]) corners.insert(corners.end(), right_views[i].begin(), right_views[i].end());
    estimate.used_pairs.push_back(static_cast<int>(i));
  }

  Problem problem(model, std::move(corners));
  problem.Solve(&state, true);
  const std::vector<double> first_errors = problem.Errors(state);
  // The median of the length of two normal errors is 1.177 standard deviations.
  const double first_sigma_px = std::max(kLeastNoise_px, MedianOf(first_errors) / 1.177);
  for (size_t i = 0; i < first_errors.size(); ++i) {
    problem.corners()[i].used = first_errors[i] < kOutlierSigmas * first_sigma_px;
    (problem.corners()[i].used ? estimate.used_corners : estimate.left_out_corners) += 1;
  }
  problem.set_noise_px(first_sigma_px);
  problem.Solve(&state, false);
  double sum = 0.0;
  const std::vector<double> errors = problem.Errors(state);
  for (size_t i = 0; i < errors.size(); ++i) sum += problem.corners()[i].used ? errors[i] * errors[i] : 0.0;
  const double n_parameters = static_cast<double>(2 * state.left.size() + 6 + 6 * estimate.used_pairs.size());
  estimate.noise_px = std::sqrt(sum / std::max(1.0, 2.0 * estimate.used_corners - n_parameters));

  problem.set_noise_px(std::max(1e-6, estimate.noise_px));
  const Eigen::MatrixXd covariance = problem.Covariance(&state);
  const auto n = static_cast<Eigen::Index>(state.left.size());
  estimate.left_covariance = covariance.topLeftCorner(n, n);
  estimate.right_covariance = covariance.block(n, n, n, n);
  // From angle, axis and translation of T_right_left to its inverse, by differences.
  const SE3 T_left_right = ToSE3(state.T_right_left).Inverse();
  Matrix6d J;
  for (size_t k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-6;
    Pose moved = state.T_right_left;
    moved[k] += kStep;
    J.col(static_cast<Eigen::Index>(k)) = (T_left_right.Inverse() * ToSE3(moved).Inverse()).Log() / kStep;
  }
  const Matrix6d rig_covariance = J * covariance.bottomRightCorner(6, 6) * J.transpose();
  estimate.T_left_right_sigma = rig_covariance.diagonal().cwiseSqrt();
  const Eigen::Matrix3d R = T_left_right.rotation().toRotationMatrix();
  estimate.right_in_left_sigma_m = (R * rig_covariance.topLeftCorner(3, 3) * R.transpose()).diagonal().cwiseSqrt();
  const Eigen::Vector3d direction = T_left_right.rotation().conjugate() * T_left_right.translation().normalized();
  estimate.baseline_sigma_m = std::sqrt(direction.dot(rig_covariance.topLeftCorner(3, 3) * direction));

  RigCalibration& rig = estimate.rig;
  rig.left = ToCamera(state.left, model, size);
  rig.right = ToCamera(state.right, model, size);
  rig.right.T_b_cam = T_left_right;
  rig.baseline_m = T_left_right.translation().norm();
  return estimate;
}

std::vector<int> ChoosePairs(const std::vector<BoardPair>& pairs, const ImageSize& size, int n) {
  constexpr int kColumns = 12, kRows = 8;
  std::vector<std::vector<size_t>> cells(pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    for (const bool is_right : {false, true}) {
      for (const Eigen::Vector2d& p : is_right ? pairs[i].right.pixels : pairs[i].left.pixels) {
        cells[i].push_back((is_right ? kColumns * kRows : 0) + CellOf(p, size, kColumns, kRows));
      }
    }
  }
  std::vector<double> count(2 * kColumns * kRows, 0.0);
  std::vector<int> chosen;
  std::vector<bool> taken(pairs.size(), false);
  while (static_cast<int>(chosen.size()) < n) {
    double best = 0.0;
    int best_pair = -1;
    for (size_t i = 0; i < pairs.size(); ++i) {
      if (taken[i]) continue;
      double gain = 0.0;
      for (const size_t cell : cells[i]) gain += 1.0 / (1.0 + count[cell]);
      if (gain > best) {
        best = gain;
        best_pair = static_cast<int>(i);
      }
    }
    if (best_pair < 0) break;
    taken[static_cast<size_t>(best_pair)] = true;
    chosen.push_back(best_pair);
    for (const size_t cell : cells[static_cast<size_t>(best_pair)]) count[cell] += 1.0;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace plslam::calibration
