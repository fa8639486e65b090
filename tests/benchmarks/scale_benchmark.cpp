// SPDX-License-Identifier: BSD-3-Clause
// Cost of a loop in a large map, stage by stage, and of refining it, by the number of keyframes. The maps are synthetic: keyframes twice
// round a circle with drifted odometry, each with points and lines that neighbouring keyframes observe, too, measured
// with noise; the newest keyframe is recognised at the beginning of the first lap.
//
//   scale_benchmark 1000 3000 10000

#include <ctime>
#include <fstream>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/bus/messages/loop_channel.h"
#include "core/bus/messages/map_pages.h"
#include "core/io/maps/map_file.h"
#include "core/map/map_follower.h"
#include "core/process/process_usage.h"
#include "loop_process/global_bundle.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/loop_correction.h"
#include "mapping_process/mapper.h"
#include "tests/support/feature_world.h"
#include "tools/refine/refine_map.h"

namespace plslam {
namespace {

constexpr int kSeenBy = 8;
constexpr int kNewPoints = 25;  // of each keyframe; so it sees eight times as many
constexpr int kNewLines = 4;
constexpr double kStep_m = 0.4;
constexpr double kNoise_px = 0.4;
constexpr double kMotionSigma_m = 0.002;
constexpr double kMotionSigma_rad = 0.0004;

const StereoCamera kCamera = test::FeatureWorld::Camera();

double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

double ResidentMB() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return 1e-3 * std::stod(line.substr(6));
  }
  return 0.0;
}

class MadeUpMap {
 public:
  explicit MadeUpMap(int n) : n_(n), random_(static_cast<uint64_t>(n)) {
    for (int i = 0; i < n; ++i) AddKeyframe(i);
    for (int i = 0; i < n; ++i) AddLandmarks(i);
  }

  StoredMap Take() {
    map_.ForgetChanges();
    StoredMap stored;
    stored.next_keyframe_id = n_;
    stored.next_point_id = LandmarkId(next_point_);
    stored.next_line_id = LandmarkId(next_line_);
    stored.sessions[1] = {n_ - 1, n_ - 1};
    stored.newest_session = 1;
    stored.version = 1;
    stored.map = std::move(map_);
    for (auto& [id, features] : features_) stored.features[id] = std::move(features);
    return stored;
  }

  /// The last keyframe begins the third lap; a lap before, the camera was at the same position.
  LoopEdge Loop() const {
    LoopEdge edge;
    edge.old_keyframe_id = 0;
    edge.keyframe_id = n_ - 1;
    edge.T_old_kf = TruePose(0).Inverse() * TruePose(n_ - 1);
    edge.covariance = 1e-5 * Matrix6d::Identity();
    edge.n_points = 100;
    return edge;
  }

  double Error_m(const Map& map) const {
    double sum = 0.0;
    for (const auto& [id, keyframe] : map.keyframes()) {
      sum += (keyframe.T_w_kf.translation() - TruePose(static_cast<int>(id.value)).translation()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(map.keyframes().size()));
  }

 private:
  double Gauss() { return gauss_(random_); }
  double Across() { return across_(random_); }

  SE3 TruePose(int i) const {
    const double a = 4.0 * std::numbers::pi * i / (n_ - 1);
    const double radius_m = kStep_m * (n_ - 1) / (4.0 * std::numbers::pi);
    return {ExpSO3({0.0, a, 0.0}), {radius_m * (1.0 - std::cos(a)), 0.0, radius_m * std::sin(a)}};
  }

  void AddKeyframe(int i) {
    MapKeyframe keyframe;
    keyframe.name.number = i;
    keyframe.frame_id = FrameId(i);
    keyframe.id = KeyframeId(keyframe.name.number);
    keyframe.name.session = 1;
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(kMotionSigma_m), Eigen::Vector3d::Constant(kMotionSigma_rad);
    if (i == 0) {
      keyframe.T_w_kf = TruePose(0);
    } else {
      Vector6d error;
      for (int k = 0; k < 6; ++k) error[k] = sigma[k] * Gauss();
      keyframe.previous_id = keyframe.parent_id = i - 1;
      keyframe.T_prevkf_kf = TruePose(i - 1).Inverse() * TruePose(i) * SE3::Exp(error);
      keyframe.relative_covariance = Matrix6d(sigma.cwiseAbs2().asDiagonal());
      keyframe.T_w_kf = map_.FindKeyframe(i - 1)->T_w_kf * keyframe.T_prevkf_kf;
      keyframe.covariance = static_cast<double>(i) * keyframe.relative_covariance;
    }
    keyframe.T_odom_kf = keyframe.T_w_kf;
    map_.Put(keyframe);
    features_[i];
  }

  Eigen::Vector3d Observed(const Eigen::Vector3d& p_c) {
    return kCamera.ProjectStereo(p_c) + kNoise_px * Eigen::Vector3d{Gauss(), Gauss(), Gauss()};
  }

  void AddLandmarks(int i) {
    // After the last keyframe no keyframe would observe new landmarks.
    const int last = std::min(n_, i + kSeenBy);
    if (last - i < 2) return;
    const auto in_view = [this](double depth_m) {
      return Eigen::Vector3d(0.6 * depth_m * Across(), 0.45 * depth_m * Across(), depth_m);
    };
    for (int k = 0; k < kNewPoints; ++k) {
      const Eigen::Vector3d p_kf = in_view(5.0 + kSeenBy * kStep_m + 4.0 * std::abs(Across()));
      MapPoint point;
      point.id = LandmarkId(next_point_++);
      point.p_w = map_.FindKeyframe(i)->T_w_kf * p_kf;
      point.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      point.descriptor = {random_(), random_(), random_(), random_()};
      point.depth_m = p_kf.z();
      for (int j = i; j < last; ++j) {
        const Eigen::Vector3d uvd = Observed(TruePose(j).Inverse() * (TruePose(i) * p_kf));
        StereoPoint seen;
        seen.left.px = uvd.head<2>();
        seen.left.descriptor = point.descriptor;
        seen.disparity_px = uvd.z();
        seen.sigma_px = seen.sigma_disparity_px = kNoise_px;
        auto& of_keyframe = features_.at(j).points;
        point.observations.push_back({j, static_cast<int32_t>(of_keyframe.size())});
        of_keyframe.push_back(seen);
      }
      map_.Put(point);
    }
    for (int k = 0; k < kNewLines; ++k) {
      const Eigen::Vector3d p_kf = in_view(5.0 + kSeenBy * kStep_m + 4.0 * std::abs(Across()));
      const Eigen::Vector3d q_kf = p_kf + Eigen::Vector3d(0.5 * Across(), 1.0, 0.2 * Across());
      MapLine line;
      line.id = LandmarkId(next_line_++);
      line.segment_w = {map_.FindKeyframe(i)->T_w_kf * p_kf, map_.FindKeyframe(i)->T_w_kf * q_kf};
      line.covariance_p = line.covariance_q = 1e-4 * Eigen::Matrix3d::Identity();
      line.descriptor = {random_(), random_(), random_(), random_()};
      for (int j = i; j < last; ++j) {
        const SE3 T_j_i = TruePose(j).Inverse() * TruePose(i);
        const Eigen::Vector3d p = Observed(T_j_i * p_kf);
        const Eigen::Vector3d q = Observed(T_j_i * q_kf);
        StereoLine seen;
        seen.left.segment = {p.head<2>(), q.head<2>()};
        seen.left.descriptor = line.descriptor;
        seen.disparity_p_px = p.z();
        seen.disparity_q_px = q.z();
        seen.sigma_px = seen.sigma_disparity_p_px = seen.sigma_disparity_q_px = kNoise_px;
        auto& of_keyframe = features_.at(j).lines;
        line.observations.push_back({j, static_cast<int32_t>(of_keyframe.size())});
        of_keyframe.push_back(seen);
      }
      map_.Put(line);
    }
  }

  int n_;
  std::mt19937_64 random_;
  std::normal_distribution<double> gauss_;
  std::uniform_real_distribution<double> across_{-1.0, 1.0};
  Map map_;
  std::map<KeyframeId, StereoFeatures> features_;
  int64_t next_point_ = 0;
  int64_t next_line_ = 0;
};

/// A line of the table.
void Row(const std::string& stage, double cpu_ms, const std::string& rest) {
  fmt::print("  {:<44} {:>9.1f} ms  {}\n", stage, cpu_ms, rest);
}

template <class Work>
double Cpu(const Work& work) {
  const double began_ms = CpuMs();
  work();
  return CpuMs() - began_ms;
}

template <class Pages>
double MegabytesOf(const Pages& pages) {
  double bytes = 0.0;
  for (const auto& page : pages) bytes += page.getEncodedSize();
  return 1e-6 * bytes;
}

/// Sends the last update of the mapper to a copy of the map.
void TellUpdate(mapping::Mapper& mapper, MapFollower& replica) {
  const MapUpdate update = mapper.TakeUpdate();
  std::vector<map_update_t> pages;
  const double cut_ms = Cpu([&] { pages = bus::CutIntoPages(update, 60'000); });
  Row("  update sent", cut_ms, fmt::format("{:.2f} MB", MegabytesOf(pages)));
  bus::MapUpdateAssembler assembler;
  const double apply_ms = Cpu([&] {
    for (const map_update_t& page : pages) assembler.Add(page);
    MapUpdate received = assembler.Take();
    received.base_version = update.base_version;
    replica.Apply(received);
  });
  Row("  update taken over by a reader", apply_ms, replica.version()->number == mapper.version() ? "" : "REFUSED");
}

void Measure(int n) {
  MadeUpMap made(n);
  StoredMap stored = made.Take();
  const KeyframeFeatures features = stored.features;
  const MapTotals totals = stored.map.Totals();
  fmt::print("{} keyframes, {} points, {} lines, {} observations; {:.2f} m off\n", totals.keyframes, totals.points,
             totals.lines, totals.point_observations + totals.line_observations, made.Error_m(stored.map));
  size_t file_bytes = 0;
  const double encode_ms = Cpu([&] { file_bytes = EncodeMap(stored).size(); });
  Row("map encoded", encode_ms, fmt::format("{:.1f} MB", 1e-6 * static_cast<double>(file_bytes)));
  mapping::Mapper mapper(kCamera, {}, std::move(stored));
  MapFollower replica;
  const MapUpdate whole = mapper.Whole();
  Row("whole map taken over by a reader", Cpu([&] { replica.Apply(whole); }),
      fmt::format("{:.1f} MB", MegabytesOf(bus::CutIntoPages(whole, 60'000))));
  const double resident_MB = ResidentMB();

  const LoopEdge edge = made.Loop();
  std::optional<std::vector<CorrectedPose>> poses;
  const double graph_ms = Cpu([&] { poses = loop::CloseLoop(mapper.map(), edge, {}); });
  if (!poses) return fmt::print("  the loop is not believed\n");
  LoopClosure loop;
  loop.kind = LoopClosure::Kind::kLoop;
  loop.keyframe.session = 1;
  loop.keyframe.number = n - 1;
  loop.edges = {edge};
  loop.poses = *poses;
  loop.map_version = MapVersion{{}, {}, mapper.version()};
  loop.names = loop::NamesIn(mapper.map(), loop);
  Row("pose graph", graph_ms, "");
  std::string reason;
  const double loop_ms = Cpu([&] { mapper.Correct(loop, &reason); });
  Row("loop taken over by the map", loop_ms, fmt::format("{:.2f} m off{}", made.Error_m(mapper.map()), reason));
  TellUpdate(mapper, replica);

  std::optional<loop::GlobalBundleProblem> problem;
  const double problem_ms =
      Cpu([&] { problem = loop::MakeGlobalBundleProblem(replica.map(), features, kCamera, {}); });
  Row("global bundle adjustment: problem", problem_ms,
      fmt::format("{} points, {} lines", problem->bundle.points.size(), problem->bundle.lines.size()));
  problem->keyframe.session = 1;
  problem->keyframe.number = n - 1;
  problem->map_version = MapVersion{{}, {}, mapper.version()};
  LoopClosure adjusted;
  const double adjust_ms = Cpu([&] { adjusted = loop::AdjustGlobally(*problem, {}, nullptr, &reason); });
  Row("global bundle adjustment", adjust_ms, reason);
  const double correct_ms = Cpu([&] { mapper.Correct(adjusted, &reason); });
  Row("adjustment taken over by the map", correct_ms,
      fmt::format("{:.2f} m off{}", made.Error_m(mapper.map()), reason));
  TellUpdate(mapper, replica);

  StoredMap refined = mapper.Store();
  StereoCamera camera = kCamera;
  refine::RefineOptions options;
  options.memory_bytes = uint64_t{4} << 30;
  options.announce = [](const std::string& sentence) { fmt::print("  refine: {}\n", sentence); };
  refine::RefineReport report;
  const double refine_ms = Cpu([&] { report = refine::RefineMap(refined, camera, options); });
  Row("refine", refine_ms,
      fmt::format("{} passes, {:.3f} m off, peak of the whole process {:.0f} MB", report.passes.size(),
                  made.Error_m(refined.map), bus::PeakMemory_mb()));
  fmt::print("  {:<44} {:>9.0f} MB of the map, its features twice, and a copy of the map\n", "resident", resident_MB);
}

}  // namespace
}  // namespace plslam

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) plslam::Measure(std::stoi(argv[i]));
  if (argc < 2) plslam::Measure(1000);
  return 0;
}
