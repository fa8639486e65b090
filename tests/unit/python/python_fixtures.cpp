// SPDX-License-Identifier: BSD-3-Clause
// The C++ side of the tests of the Python package:
//
//   python_fixtures files FOLDER        maps, logs and the files of a run, and their values in expected.json
//   python_fixtures publish URL PREFIX  POSE 0, 1, 2, ... of a process, for two minutes at most
//   python_fixtures receive URL         "ready", then the first pair of images on CAMERA as JSON;
//                                       null if none arrives within a minute

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>

#include "adapter/node/foreign_messages.h"
#include "core/bus/bus.h"
#include "core/bus/channels.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/io/maps/map_camera.h"
#include "core/io/trajectories/pose_covariance.h"
#include "core/io/trajectories/trajectory.h"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "tests/unit/map_file/stored_maps.h"

namespace plslam::test {
namespace {

using nlohmann::json;

constexpr int64_t kBegin_ns = 1'700'000'000'123'456'789;
constexpr int kLoggedPoses = 20;

/// Row by row; a vector is one row.
template <class Matrix>
json Rows(const Matrix& matrix) {
  json rows = json::array();
  for (int r = 0; r < matrix.rows(); ++r) {
    json row = json::array();
    for (int c = 0; c < matrix.cols(); ++c) row.push_back(static_cast<double>(matrix(r, c)));
    rows.push_back(row);
  }
  return matrix.cols() == 1 ? Rows(matrix.transpose().eval())[0] : rows;
}

json Rows(const LandmarkCovariance& covariance) { return Rows(covariance.matrix()); }
json Rows(const SE3& T) { return Rows(T.matrix()); }

json Bytes(const Descriptor& descriptor) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(descriptor.data());
  return std::vector<uint8_t>(bytes, bytes + sizeof(descriptor));
}

template <class Landmark>
json Observations(const Landmark& landmark) {
  json rows = json::array();
  for (const Observation& of : landmark.observations) rows.push_back({of.keyframe_id().value, int32_t{of.feature}});
  return rows;
}

json Values(const MapKeyframe& k) {
  return {{"id", k.id.value},
          {"session", k.name.session.value},
          {"session_keyframe_id", k.name.number},
          {"frame_id", k.frame_id.value},
          {"t_ns", k.t_ns},
          {"T_w_kf", Rows(k.T_w_kf)},
          {"covariance", Rows(k.covariance)},
          {"T_odom_kf", Rows(k.T_odom_kf)},
          {"previous_id", k.previous_id.value},
          {"T_prevkf_kf", Rows(k.T_prevkf_kf)},
          {"relative_covariance", Rows(k.relative_covariance)},
          {"parent_id", k.parent_id.value},
          {"up_c", Rows(k.up ? k.up->direction : Eigen::Vector3d::Zero())},
          {"up_sigma_rad", k.up ? k.up->sigma_rad : 0.0}};
}

json Values(const MapPoint& p) {
  return {{"id", p.id.value},
          {"p_w", Rows(p.p_w)},
          {"covariance", Rows(p.covariance)},
          {"descriptor", Bytes(p.descriptor)},
          {"octave", p.octave},
          {"depth_m", p.depth_m},
          {"observations", Observations(p)}};
}

json Values(const MapLine& l) {
  return {{"id", l.id.value},
          {"p_w", Rows(l.segment_w.p)},
          {"q_w", Rows(l.segment_w.q)},
          {"covariance_p", Rows(l.covariance_p)},
          {"covariance_q", Rows(l.covariance_q)},
          {"descriptor", Bytes(l.descriptor)},
          {"observations", Observations(l)}};
}

json Values(const StereoPoint& p) {
  return {{"px", Rows(p.left.px)},
          {"response", p.left.response},
          {"angle_rad", p.left.angle_rad},
          {"octave", p.left.octave},
          {"descriptor", Bytes(p.left.descriptor)},
          {"scale", p.left.scale},
          {"disparity_px", p.disparity_px},
          {"sigma_px", p.sigma_px},
          {"sigma_disparity_px", p.sigma_disparity_px}};
}

json Values(const StereoLine& l) {
  return {{"p_px", Rows(l.left.segment.p)},
          {"q_px", Rows(l.left.segment.q)},
          {"response", l.left.response},
          {"octave", l.left.octave},
          {"descriptor", Bytes(l.left.descriptor)},
          {"disparity_p_px", l.disparity_p_px},
          {"disparity_q_px", l.disparity_q_px},
          {"sigma_px", l.sigma_px},
          {"sigma_disparity_p_px", l.sigma_disparity_p_px},
          {"sigma_disparity_q_px", l.sigma_disparity_q_px}};
}

json Values(const LoopEdge& loop) {
  return {{"old_keyframe_id", loop.old_keyframe_id.value},
          {"keyframe_id", loop.keyframe_id.value},
          {"position", Rows(loop.T_old_kf.translation())},
          {"q_xyzw", Rows(loop.T_old_kf.rotation().coeffs())},
          {"covariance", Rows(loop.covariance)},
          {"n_points", loop.n_points},
          {"n_lines", loop.n_lines}};
}

template <class Elements>
json All(const Elements& elements) {
  json rows = json::array();
  for (const auto& element : elements) {
    if constexpr (requires { element.second; }) {
      rows.push_back(Values(element.second));
    } else {
      rows.push_back(Values(element));
    }
  }
  return rows;
}

/// Writes a map of two cameras; returns its values.
json WriteMap(const std::string& path, uint64_t seed, int steps) {
  StoredMap stored = OfTwoCameras(seed, steps);
  stored.rig = CameraBytes({420.5, 375.25, 239.75, 0.11, 752, 480});
  WriteMapFile(path, stored);
  json features;
  for (const auto& [id, of] : stored.features) {
    json image;
    if (of.image) {
      const TakenImage& i = *of.image;
      image = {i.left_px, i.top_px, i.width_px, i.height_px, i.f_px};
    }
    features[std::to_string(id.value)] = {{"points", All(of.points)}, {"lines", All(of.lines)}, {"image", image}};
  }
  return {{"version", stored.version},
          {"camera",
           {{"f_px", 420.5},
            {"cx_px", 375.25},
            {"cy_px", 239.75},
            {"baseline_m", 0.11},
            {"width_px", 752},
            {"height_px", 480}}},
          {"keyframes", All(stored.map.keyframes())},
          {"points", All(stored.map.points())},
          {"lines", All(stored.map.lines())},
          {"loops", All(stored.map.loops())},
          {"features", features}};
}

/// Writes two trajectories and the covariances of a run; returns the values of its final poses.
json WriteRun(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  Trajectory trajectory, live;
  std::vector<PoseCovariance> covariances;
  json poses = json::array();
  for (int i = 0; i < 30; ++i) {
    const int64_t t_ns = kBegin_ns + i * 33'333'333LL;
    Vector6d x;
    for (double& value : x) value = uniform(random);
    trajectory.push_back({t_ns, SE3::Exp(x)});
    live.push_back({t_ns, SE3::Exp(0.5 * x)});
    covariances.push_back({t_ns, x * x.transpose()});
    poses.push_back({{"t_ns", t_ns},
                     {"T", Rows(trajectory.back().T_a_b)},
                     {"T_live", Rows(live.back().T_a_b)},
                     {"covariance", Rows(covariances.back().covariance)}});
  }
  WriteTrajectory(folder / "trajectory.tum", TrajectoryFormat::kTum, trajectory);
  WriteTrajectory(folder / "trajectory_live.tum", TrajectoryFormat::kTum, live);
  WritePoseCovariances(folder / "covariance.txt", covariances);
  return poses;
}

/// A pose that is recognised by its number.
pose_t PoseNumber(int i) {
  pose_t pose{};
  pose.header.t_ns = kBegin_ns + i;
  pose.frame_id = i;
  pose.T_odom_c.position_m[2] = 0.25 * i;
  pose.T_odom_c.q_wxyz[0] = 1.0;
  pose.T_w_odom.q_wxyz[0] = 1.0;
  pose.n_stages = 1;
  pose.stages.resize(1);
  pose.stages[0].name = "match";
  pose.stages[0].ms = i;
  return pose;
}

bus::BusOptions OptionsOf(const std::string& url, const std::string& prefix) {
  bus::BusOptions options;
  options.url = url;
  options.prefix = prefix;
  return options;
}

/// Writes poses and a status.
void WriteLog(const std::string& path, const std::string& prefix) {
  bus::Bus bus(OptionsOf("file://" + path + "?mode=w", prefix), "vo");
  for (int i = 0; i < kLoggedPoses; ++i) bus.Publish(bus::kPose, PoseNumber(i));
  status_t status{};
  status.process = "vo";
  status.state = "running";
  bus.Publish(bus::kStatus, status);
}

void WriteFiles(const std::filesystem::path& folder) {
  json expected;
  expected["map"] = WriteMap(folder / "room.plmap", 7, 600);
  WriteMap(folder / "small.plmap", 10, 60);
  expected["run"] = WriteRun(folder / "run");
  WriteLog(folder / "run.lcm", "");
  WriteLog(folder / "front.lcm", "front/");
  for (int i = 0; i < kLoggedPoses; ++i) {
    expected["log"].push_back({{"frame_id", i}, {"t_ns", kBegin_ns + i}, {"z_m", 0.25 * i}, {"stage", "match"}});
  }
  for (const bus::Channel& channel : bus::Channels()) expected["channels"].push_back(channel.name);
  std::ofstream(folder / "expected.json") << expected;
}

void Publish(const std::string& url, const std::string& prefix) {
  bus::Bus bus(OptionsOf(url, prefix), "vo");
  for (int i = 0; i < 60'000; ++i) {
    bus.Publish(bus::kPose, PoseNumber(i));
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

json Values(const robot::ForeignImage& image) {
  return {{"t_ns", image.t_ns},           {"width_px", image.width_px},
          {"height_px", image.height_px}, {"step_bytes", image.step_bytes},
          {"encoding", image.encoding},   {"bytes", image.bytes}};
}

void Receive(const std::string& url) {
  bus::StockLcm lcm(url, "receive");
  json pair;
  lcm.Subscribe("CAMERA", [&](bus::ByteView bytes) {
    const auto [left, right] = adapter::PairFromBytes(bytes);
    pair = {Values(left), Values(right)};
  });
  printf("ready\n");
  fflush(stdout);
  for (int i = 0; i < 600 && pair.is_null(); ++i) lcm.Handle(100);
  printf("%s\n", pair.dump().c_str());
}

}  // namespace
}  // namespace plslam::test

int main(int argc, char** argv) {
  const std::string verb = argc > 2 ? argv[1] : "";
  if (verb == "files") {
    plslam::test::WriteFiles(argv[2]);
  } else if (verb == "publish" && argc == 4) {
    plslam::test::Publish(argv[2], argv[3]);
  } else if (verb == "receive") {
    plslam::test::Receive(argv[2]);
  } else {
    fprintf(stderr, "usage: python_fixtures files FOLDER | publish URL PREFIX | receive URL\n");
    return 1;
  }
  return 0;
}
