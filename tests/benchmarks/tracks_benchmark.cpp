// SPDX-License-Identifier: BSD-3-Clause
// Drift of tracked points from the surface points on which they were created: exact truth of the built-in worlds.
//
//   tracks_benchmark room?frames=60 street?seed=2

#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "core/config/config.h"
#include "core/datasets/synthetic/options.h"
#include "core/datasets/synthetic/simulator.h"
#include "tests/support/odometry_run.h"
#include "tools/command_line/run_command_line.h"
#include "vo_process/stereo/stereo_front_end.h"

namespace {

using plslam::SE3;
using plslam::StereoCamera;
using plslam::StereoPoint;
using plslam::vo::FeatureTrack;
using plslam::vo::OdometryResult;

constexpr double kWrong_px = 6.0;

// Errors of the tracks whose total flow lies in one range.
struct Bin {
  int n = 0;
  int wrong = 0;
  double flow = 0.0;
  double along = 0.0;
  double along2 = 0.0;
  double across2 = 0.0;
  double scaled2 = 0.0;
  double drift_vs_flow = 0.0;
  double d = 0.0;
  double d2 = 0.0;
  double d_scaled2 = 0.0;
  int n_d = 0;
};

class TrackScore {
 public:
  TrackScore(const plslam::synthetic::Simulator& simulator, const StereoCamera& camera)
      : simulator_(&simulator), camera_(camera) {}

  void See(int index, const plslam::vo::OdometryResult& result) {
    const SE3 T_w_c = simulator_->T_w_c(index);
    const SE3 T_c_w = T_w_c.Inverse();
    for (size_t i = 0; i < result.point_tracks.size(); ++i) {
      const plslam::vo::FeatureTrack& track = result.point_tracks[i];
      const StereoPoint& seen = result.features.points[i];
      if (track.landmark_id < 0) continue;
      const auto known = places_.find(track.landmark_id);
      if (known == places_.end()) {
        Found(T_w_c, track.landmark_id, seen);
        continue;
      }
      const Eigen::Vector3d p_c = T_c_w * known->second.p_w;
      if (p_c.z() < 0.1) continue;
      Compare(known->second.px, camera_.ProjectStereo(p_c), seen);
    }
  }

  void Print(const std::string& name) const {
    std::printf(
        "%s\n   flow px      n  wrong%%   along mean   rms  across rms  (of flow %%)  in sigmas |  d mean    rms  in "
        "sigmas\n",
        name.c_str());
    for (const auto& [limit, b] : bins_) {
      const double n = std::max(b.n, 1);
      const double n_d = std::max(b.n_d, 1);
      std::printf("%6.0f %9.1f %7d  %5.2f   %+8.3f  %7.3f  %7.3f    %+7.3f    %6.2f    | %+7.3f %7.3f %6.2f\n", limit,
                  b.flow / n, b.n, 100.0 * b.wrong / (n + b.wrong), b.along / n, std::sqrt(b.along2 / n),
                  std::sqrt(b.across2 / n), 100.0 * b.along / std::max(b.flow, 1e-9),
                  std::sqrt(b.scaled2 / (2.0 * n)), b.d / n_d, std::sqrt(b.d2 / n_d), std::sqrt(b.d_scaled2 / n_d));
    }
  }

 private:
  struct Place {
    Eigen::Vector3d p_w;
    Eigen::Vector2d px;
  };

  void Found(const SE3& T_w_c, plslam::TrackId id, const StereoPoint& seen) {
    const Eigen::Vector3d ray_c((seen.left.px.x() - camera_.cx_px) / camera_.f_px,
                                (seen.left.px.y() - camera_.cy_px) / camera_.f_px, 1.0);
    const Eigen::Vector3d ray_w = T_w_c.R() * ray_c;
    const auto depth = simulator_->world().CastRay(T_w_c.translation(), ray_w);
    // At the border of an object the corner is of one surface and the ray may meet the other.
    const bool same =
        depth && seen.HasDepth() && std::abs(camera_.FocalBaseline() / *depth - seen.disparity_px) < 0.5;
    if (same) places_[id] = {T_w_c.translation() + *depth * ray_w, seen.left.px};
  }

  void Compare(const Eigen::Vector2d& founded_px, const Eigen::Vector3d& truth_uvd, const StereoPoint& seen) {
    const Eigen::Vector2d flow = truth_uvd.head<2>() - founded_px;
    const double length = flow.norm();
    double limit = 4.0;
    while (limit < length) limit *= 2.0;
    Compare(limit, length, flow, truth_uvd, seen);
  }

  void Compare(double limit, double length, const Eigen::Vector2d& flow, const Eigen::Vector3d& truth_uvd,
               const StereoPoint& seen) {
    Bin& bin = bins_[limit];
    const Eigen::Vector2d error = seen.left.px - truth_uvd.head<2>();
    if (error.norm() > kWrong_px) {
      ++bin.wrong;
      return;
    }
    const Eigen::Vector2d direction = length > 0.0 ? Eigen::Vector2d(flow / length) : Eigen::Vector2d(1.0, 0.0);
    const double along = direction.dot(error);
    ++bin.n;
    bin.flow += length;
    bin.along += along;
    bin.along2 += along * along;
    bin.across2 += error.squaredNorm() - along * along;
    bin.scaled2 += error.squaredNorm() / (seen.sigma_px * seen.sigma_px);
    if (!seen.HasDepth()) return;
    const double d = seen.disparity_px - truth_uvd.z();
    if (std::abs(d) > kWrong_px) return;
    ++bin.n_d;
    bin.d += d;
    bin.d2 += d * d;
    bin.d_scaled2 += d * d / (seen.sigma_disparity_px * seen.sigma_disparity_px);
  }

  const plslam::synthetic::Simulator* simulator_;
  StereoCamera camera_;
  std::map<plslam::TrackId, Place> places_;
  std::map<double, Bin> bins_;
};

void ScoreWorld(const std::string& world, const plslam::vo::VoOptions& options) {
  const plslam::synthetic::Simulator simulator(plslam::synthetic::ParseOptions(world));
  const auto dataset = plslam::OpenSyntheticDataset(world);
  TrackScore score(simulator, plslam::vo::StereoFrontEnd(dataset->rig(), options).camera());
  int index = 0;
  const auto frames = plslam::test::RunOdometry(
      *dataset, options, 1, 1 << 30,
      [&](const plslam::StereoImages&, const plslam::vo::OdometryResult& result) { score.See(index++, result); });
  score.Print(world + " ate " + std::to_string(plslam::test::AbsoluteTrajectoryError(frames)));
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> worlds;
  std::vector<std::string> overrides;
  CLI::App app("Errors of tracked points against the truth of synthetic worlds", "tracks_benchmark");
  app.add_option("worlds", worlds, "as after synthetic:")->required();
  app.add_option("--set", overrides, "KEY=VALUE");
  return plslam::RunCommandLine(app, argc, argv, [&] {
    cv::setNumThreads(1);
    plslam::Config config;
    for (const std::string& assignment : overrides) config.Override(assignment);
    plslam::vo::VoOptions options;
    config.Read("vo", options);
    for (const std::string& world : worlds) ScoreWorld(world, options);
    return 0;
  });
}
