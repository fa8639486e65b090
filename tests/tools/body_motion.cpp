// SPDX-License-Identifier: BSD-3-Clause
#include "tests/tools/body_motion.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/datasets/synthetic/exact_math.h"

namespace plslam::test {
namespace {

using synthetic::Random;
using synthetic::Smoothstep;

constexpr double kLeadDisparity = 0.045;  // of the width of the image
constexpr double kLeadDepth_m = 7.0;      // the depth for which sizes in metres are given; other depths scale them
constexpr int kSmoothing = 7;             // frames to both sides

SE3 Smoothed(const std::vector<SE3>& path, int i) {
  const int half = std::min({kSmoothing, i, static_cast<int>(path.size()) - 1 - i});
  Vector6d mean = Vector6d::Zero();
  for (int k = -half; k <= half; ++k) mean += (path[i].Inverse() * path[i + k]).Log();
  return path[i] * SE3::Exp(mean / (2 * half + 1));
}

struct Scene {
  StereoCamera camera;
  double share = 0.0;
  double depth_m = 0.0;
  double unit = 1.0;  // metres of a scene whose vehicle ahead is at kLeadDepth_m
  double frames = 0.0;
  Random random;

  double Width(double depth) const { return camera.width_px * depth / camera.f_px; }
  double Height(double depth) const { return camera.height_px * depth / camera.f_px; }
  // The middle of the image.
  Eigen::Vector3d Middle(double depth) const {
    return {(0.5 * camera.width_px - camera.cx_px) * depth / camera.f_px,
            (0.5 * camera.height_px - camera.cy_px) * depth / camera.f_px, depth};
  }
};

// Offset of the body's centre from the camera's path at a frame.
using Offset = std::function<SE3(double frame)>;

struct Plan {
  Eigen::Vector3d size_m;
  Offset offset;
};

SE3 At(const Eigen::Vector3d& p) { return {Eigen::Quaterniond::Identity(), p}; }

// 0 at `from` (share of the frames), 1 at `to`; constant speed, also outside.
double Progress(const Scene& scene, double frame, double from, double to) {
  return (frame / scene.frames - from) / (to - from);
}

Plan Lead(Scene& scene) {
  const double z = scene.depth_m;
  const Eigen::Vector3d size(scene.share * scene.Width(z), 0.7 * scene.Height(z), 1.5 * scene.share * scene.Width(z));
  Eigen::Vector3d rear = scene.Middle(z);
  rear.x() += scene.random.Uniform(-0.06, 0.06) * scene.Width(z);
  const double phase = scene.random.Uniform(0.0, 6.0);
  const double period = scene.random.Uniform(40.0, 70.0);
  return {size, [=](double frame) {
            const double angle = 2.0 * synthetic::kPi * frame / period;
            const Eigen::Vector3d own(0.01 * std::sin(angle + phase), 0.002 * std::sin(2.3 * angle),
                                      0.02 * std::sin(0.8 * angle + 2.0 * phase));
            const double yaw = 0.3 * kRadPerDeg * std::sin(0.9 * angle + phase);
            return SE3(ExpSO3({0.0, yaw, 0.0}), rear + z * own + Eigen::Vector3d(0.0, 0.0, 0.5 * size.z()));
          }};
}

Plan Overtake(Scene& scene) {
  const double unit = scene.unit;
  const double scale = unit * scene.share / 0.45;
  const Eigen::Vector3d size = scale * Eigen::Vector3d(2.5, 3.8, 12.0);
  const double lateral = unit * scene.random.Uniform(1.4, 2.2);
  return {size, [=](double frame) {
            // The lorry's rear, which must have passed the camera before it turns in.
            const double rear = unit * (-15.0 * scene.share / 0.45 + 32.0 * Progress(scene, frame, 0.0, 1.0));
            const double turned_in = Smoothstep((rear / unit - 1.5) / 8.0);
            const double x = -(lateral + 0.5 * size.x()) * (1.0 - 0.8 * turned_in);
            return At({x, -0.15 * unit, rear + 0.5 * size.z()});
          }};
}

// From right to left across the image, wholly outside at `from` and `to`.
double Across(const Scene& scene, double depth, double progress) {
  return scene.Middle(depth).x() + (0.5 - progress) * (1.2 + scene.share) * scene.Width(depth);
}

Plan Cross(Scene& scene) {
  const double z = 1.4 * scene.depth_m;
  const Eigen::Vector3d size(scene.share * scene.Width(z), 0.6 * scene.Height(z), 0.4 * scene.depth_m);
  const double from = scene.random.Uniform(0.05, 0.2);
  return {size, [=](double frame) {
            const double progress = Progress(scene, frame, from, from + 0.7);
            Eigen::Vector3d side = scene.Middle(z * (1.3 - 0.6 * progress));
            side.x() = Across(scene, side.z(), progress);
            side.z() += 0.5 * size.z();
            return At(side);
          }};
}

Plan Bus(Scene& scene) {
  const double z = scene.depth_m;
  const Eigen::Vector3d size(scene.share * scene.Width(z), 0.75 * scene.Height(z), 0.4 * z);
  return {size, [=](double frame) {
            Eigen::Vector3d side = scene.Middle(z);
            side.x() = Across(scene, z, Progress(scene, frame, 0.1, 0.9));
            side.z() += 0.5 * size.z();
            return At(side);
          }};
}

Plan Oncoming(Scene& scene) {
  const double unit = scene.unit;
  const Eigen::Vector3d size = unit * scene.share / 0.45 * Eigen::Vector3d(2.5, 3.0, 8.0);
  const double lateral = unit * scene.random.Uniform(1.3, 2.2);
  const double from = scene.random.Uniform(0.1, 0.3);
  return {size, [=](double frame) {
            const double z = unit * (60.0 - 67.0 * Progress(scene, frame, from, from + 0.6));
            return At({-(lateral + 0.5 * size.x()), -0.1 * unit, z});
          }};
}

struct Kind {
  const char* name;
  Plan (*plan)(Scene&);
};

constexpr Kind kKinds[] = {
    {"lead", Lead}, {"overtake", Overtake}, {"cross", Cross}, {"oncoming", Oncoming}, {"bus", Bus}};

}  // namespace

const std::vector<std::string>& BodyKindNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.emplace_back(kind.name);
    return all;
  }();
  return names;
}

MovingBox MoveBody(const BodyRequest& request, const StereoCamera& camera, const std::vector<SE3>& T_w_c) {
  const double usual_depth_m = camera.Depth(kLeadDisparity * camera.width_px);
  const double depth_m = request.depth_m > 0.0 ? request.depth_m : usual_depth_m;
  const double frames = std::max(static_cast<double>(T_w_c.size()) - 1.0, 1.0);
  Scene scene{camera, request.share, depth_m, depth_m / kLeadDepth_m, frames, Random(request.seed)};
  const auto* kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& row) { return request.kind == row.name; });
  const Plan plan = kind->plan(scene);
  MovingBox box{plan.size_m, {}};
  for (size_t i = 0; i < T_w_c.size(); ++i) {
    box.T_w_b.push_back(Smoothed(T_w_c, static_cast<int>(i)) * plan.offset(static_cast<double>(i)));
  }
  return box;
}

}  // namespace plslam::test
