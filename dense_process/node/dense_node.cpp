// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/node/dense_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/errors/log.h"
#include "core/errors/standard_streams.h"
#include "core/geometry/image_mask.h"
#include "core/map/vertical.h"
#include "core/motion/robust.h"
#include "core/process/order.h"
#include "core/run/process_names.h"
#include "dense_process/products.h"
#include "plslam/command_answer_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/mask_t.hpp"
#include "plslam/run_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "plslam/tracks_t.hpp"

namespace plslam::dense {
namespace {

// The median depth of the points of the first keyframe that separates rooms from roads, and the voxels of both.
constexpr double kIndoors_m = 8.0;
constexpr double kIndoorVoxel_m = 0.05;
constexpr double kRoadVoxel_m = 0.2;
// Below this share of points with the same disparity as in the keyframe the pair does not fit its calibration.
constexpr double kLeastAgreement = 0.6;
constexpr int kLeastCompared = 50;
// Rows that are off by more, in the mean of a keyframe's points, are reported.
constexpr double kFarRows_px = 0.75;
// Removed keyframes that are remembered for the driven path and for submaps: some 3 MB.
constexpr size_t kMostRemoved = 10'000;

}  // namespace

DenseNode::DenseNode(bus::Process& process, const DenseOptions& options)
    : process_(process), options_(options), disk_(options), live_(process.bus(), options.robot_height_m, options.up) {
  // One thread: the tracker needs the other core.
  cv::setNumThreads(1);
  bus::Bus& bus = process_.bus();
  end_.OnMapper();  // surfaces need a map
  bus.Subscribe<run_t>(bus::kRun, [this](const run_t& m) { end_.OnRun(m); });
  bus.Subscribe<stream_t>(bus::kStream, [this](const stream_t& m) { OnStream(m); });
  bus.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
  bus.Subscribe<command_t>(bus::kCommand, [this](const command_t& m) { OnCommand(m); });
  bus.Subscribe<command_answer_t>(bus::kCommandAnswer, [this](const command_answer_t& m) { OnCommandAnswer(m); });
  bus.Subscribe<tracks_t>(bus::kTracks, [this](const tracks_t& m) { OnTracks(m); });
  bus.SubscribeBestEffort<tracks_t>(bus::kTracksLive, [this](const tracks_t& m) { OnTracks(m); });
  bus.Subscribe<mask_t>(bus::kMask, [this](const mask_t& m) { OnMask(m); });
  sparse_ = std::make_unique<bus::MapSubscriber>(bus, [this](const MapUpdate& update) { OnMap(update); });
  sparse_->RememberRemoved();
  camera_channel_.emplace(bus, [this](const RigCalibration& rig) { OnCamera(rig); });
  keyframes_.emplace(bus, [this](const Keyframe& keyframe) { OnKeyframe(keyframe); });
  images_.emplace(
      bus, bus::FrameSubscriber::Mode::kPictures, [this](const auto& frame) { OnFrame(frame); }, nullptr,
      static_cast<int>(WaitingKeyframes::kMostFrames));
  bus.Every(RunEnd::kTick, [this] { OnTick(); });
  process_.SetConfiguration(ToYaml("dense", options_));
  CheckOptions();
  const std::string earlier = disk_.Earlier();
  if (earlier.empty()) return;
  BeginMap(DenseMap::Read(earlier, options_.range_m));
  LogInfo("continuing the surfaces of {} keyframes in {}", map_->n_keyframes(), earlier);
}

DenseNode::~DenseNode() {
  if (std::uncaught_exceptions() == 0) {
    if (dirty_) Write();
    if (map_) disk_.KeepState(*map_, sparse_->follower().map());
  }
  const std::string failure = disk_.Failures();
  if (failure.empty()) return;
  PrintError(fmt::format("{}: error: {}", process_.name(), failure));
  process_.Finish(1);
}

/// A wrong option is an error at the start.
void DenseNode::CheckOptions() const {
  if (options_.voxel_m > LargestVoxelFor(options_.robot_height_m)) {
    throw std::runtime_error(
        fmt::format("dense.voxel_m is {}: between the floor and dense.robot_height_m ({}) no obstacle of 0.1 m fits "
                    "in voxels above {}; "
                    "choose a smaller one",
                    options_.voxel_m, options_.robot_height_m, LargestVoxelFor(options_.robot_height_m)));
  }
  try {
    VerticalOf(Map(), options_.up);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("dense.up {}", error.what()));
  }
}

void DenseNode::OnCamera(const RigCalibration& rig) {
  try {
    camera_.emplace(Camera{rig, Rectifier(rig)});
    received_.has_rig = true;
  } catch (const std::exception& error) {
    LogWarning("the rig '{}' cannot be used: {}", rig.name, error.what());
  }
  FuseAll();
}

void DenseNode::OnFrame(const bus::FrameSubscriber::Frame& frame) {
  end_.OnMessage();
  camera_channel_->Follow(frame.source);
  if (waiting_.AddImages(frame.images)) FuseAll();
}

void DenseNode::OnTracks(const tracks_t& message) {
  BodyPixels bodies;
  for (const track_point_t& point : message.points) {
    if (point.body >= 0) bodies[point.body].emplace_back(point.u_px, point.v_px);
  }
  for (const track_line_t& line : message.lines) {
    if (line.body < 0) continue;
    bodies[line.body].emplace_back(line.p_px[0], line.p_px[1]);
    bodies[line.body].emplace_back(line.q_px[0], line.q_px[1]);
  }
  if (waiting_.AddBodies({FrameId(message.frame_id), message.header.t_ns}, bodies)) FuseAll();
}

void DenseNode::OnMask(const mask_t& message) {
  const std::optional<FrameMask> mask = bus::FromMessage(message);
  if (!mask) return process_.bus().CountRejected();
  waiting_.AddMask({FrameId(message.frame_id), message.header.t_ns}, *mask);
}

void DenseNode::OnKeyframe(const Keyframe& keyframe) {
  end_.OnMessage();
  received_.keyframe = keyframe.name;
  // The histories resend keyframes that a process before this one has fused.
  if (map_ && map_->Has({keyframe.name.session, keyframe.frame_id})) return;
  waiting_.Add(keyframe);
  const int64_t n_incomplete = waiting_.n_incomplete(), n_dropped = waiting_.n_dropped();
  if (n_incomplete > 0) process_.SetCounter("keyframes.incomplete", static_cast<double>(n_incomplete));
  if (n_dropped > 0) process_.SetCounter("keyframes.dropped", static_cast<double>(n_dropped));
  FuseAll();
}

void DenseNode::OnMap(const MapUpdate& update) {
  end_.OnMessage();
  FollowMap(update.map_id);
  // A correction moves the surfaces.
  if (map_ && map_->n_keyframes() > 0) SurfacesChanged();
  FuseAll();
}

/// Another map replaces the surfaces, too; a rebuilt one has the same keyframes.
void DenseNode::FollowMap(const MapId& map) {
  const std::optional<MapId> before = std::exchange(map_id_, map);
  if (!before || map.Matches(*before)) return;
  LogInfo("the map was replaced: its surfaces are dropped");
  map_.reset();
  live_.Replace();
  waiting_.Clear();
  const std::optional<bus::Order> load = std::exchange(load_, std::nullopt);
  if (!load) return;
  const std::string surfaces = load->argument + ".surfaces";
  if (!std::filesystem::exists(surfaces)) return;
  try {
    BeginMap(DenseMap::Read(surfaces, options_.range_m));
    LogInfo("the surfaces of {} keyframes in {} are loaded", map_->n_keyframes(), surfaces);
  } catch (const std::exception& error) {
    LogWarning("the map has no surfaces: {}", error.what());
  }
}

/// Surfaces of a file keep the size of their voxels.
void DenseNode::BeginMap(DenseMap map) {
  if (options_.voxel_m > 0.0 && options_.voxel_m != map.voxel_m()) {
    throw std::runtime_error(fmt::format(
        "dense.voxel_m is {}, but the surfaces that are to be continued have voxels of {} m: leave it out, or "
        "begin a new map",
        options_.voxel_m, map.voxel_m()));
  }
  map_ = std::move(map);
  map_->SetRobot({options_.robot_height_m, options_.up});
}

void DenseNode::OnStatus(const status_t& message) {
  // A dense_process that starts late awaits keyframes from the history of a tracker that has finished.
  if (message.process == process_name::kVo)
    received_.is_tracked = message.state == process_state::kFinished && received_.keyframe.has_value();
}

void DenseNode::OnStream(const stream_t& message) {
  if (message.event == stream_event::kBegin && finished_) end_.OnNewStream();
  end_.OnStream(message.event == stream_event::kEnd);
}

void DenseNode::OnCommand(const command_t& message) {
  const std::optional<bus::Order> order = bus::OrderTo(process_, message);
  if (order && order->verb == command_verb::kFinish) process_.Finish();
  // Orders to mapping_process, which may refuse them.
  if (message.target != process_name::kMapping) return;
  const SourceId sender(message.header.source);
  if (message.verb == command_verb::kLoad)
    load_ = bus::Order{message.verb, message.argument, sender, message.header.seq};
  if (message.verb == command_verb::kReset) load_.reset();
  if (message.verb != command_verb::kSave) return;
  saves_[{sender, message.header.seq}] = {message.verb, message.argument, sender, message.header.seq};
}

/// A map that was saved gets its surfaces beside it: those of an earlier map in that file must not remain.
void DenseNode::OnCommandAnswer(const command_answer_t& message) {
  if (message.process != process_name::kMapping) return;
  const SourceId sender(message.command_source);
  const bool is_load = load_ && load_->source == sender && load_->seq == message.command_seq;
  if (is_load && !message.failure.empty()) load_.reset();
  const auto saved = saves_.extract({sender, message.command_seq});
  if (saved.empty() || !message.failure.empty()) return;
  const std::string file = bus::ToSaveRequest(saved.mapped().argument).file;
  if (map_) FollowRemovals(PosesOf(sparse_->follower().map()));
  bus::Answer(process_, saved.mapped(), disk_.SaveBeside(file, map_ ? &*map_ : nullptr, sparse_->follower().map()));
}

/// In lockstep a keyframe is fused as soon as it is committed; live, as soon as the map has it.
void DenseNode::FuseAll() {
  if (!camera_ || camera_channel_->awaits_rig() || !waiting_.HasComplete()) return;
  const MapFollower& sparse = sparse_->follower();
  const KeyframePoses poses = PosesOf(sparse.map());
  const auto is_placed = [&](const Keyframe& keyframe) {
    const bool is_final = !keyframe.lockstep || sparse.newest().HasCommitted(keyframe.name);
    return is_final && poses.contains({keyframe.name.session, keyframe.frame_id});
  };
  const std::vector<ReadyKeyframe> ready = waiting_.Take(is_placed);
  if (ready.empty()) return;
  if (map_) FollowRemovals(poses);
  for (const ReadyKeyframe& keyframe : ready) Fuse(keyframe, poses);
}

/// Without the masks of the rig and of the frame, and without moving bodies.
cv::Mat DenseNode::PixelsInUse(const ReadyKeyframe& ready, const cv::Size& size) const {
  cv::Mat in_use = camera_->rectifier.left_mask();
  if (!ready.mask.left.empty()) {
    CameraCalibration left = camera_->rig.left;
    left.mask = ready.mask.left;
    in_use = camera_->rectifier.LeftMask(DrawMask(left));
  }
  return MaskBodies(in_use, size, ready.bodies);
}

DepthImage DenseNode::DepthOf(const ReadyKeyframe& ready, const cv::Mat& left) const {
  const Rectifier& rectifier = camera_->rectifier;
  const cv::Mat in_use = PixelsInUse(ready, left.size());
  if (camera_->rig.kind == RigCalibration::Kind::kStereo) {
    return MatchPair(left, rectifier.RectifyRight(ready.images.right), in_use, rectifier.camera(),
                     ready.keyframe.features);
  }
  DepthImage depth = FromSensor(rectifier.RectifyDepth(ready.images.right), camera_->rig.depth_units_per_m);
  if (!in_use.empty()) depth.z_m.setTo(0.0, in_use == 0);
  return depth;
}

void DenseNode::Fuse(const ReadyKeyframe& ready, const KeyframePoses& poses) {
  const double began_ms = bus::NowMs();
  const Keyframe& keyframe = ready.keyframe;
  try {
    const cv::Mat left = camera_->rectifier.RectifyLeft(ready.images.left);
    const DepthImage depth = DepthOf(ready, left);
    const double matched_ms = bus::NowMs();
    if (depth.rows.size_px > kFarRows_px) {
      process_.Warn(
          "rows_off",
          fmt::format("rows of the right image are off by {:.1f} px (sigma {:.2f} px) in a keyframe: this is "
                      "corrected for the surfaces, but calibrate the cameras; `plslam rectify-check` measures it",
                      depth.rows.size_px, depth.rows.sigma_px));
    }
    if (depth.n_compared >= kLeastCompared && depth.agreement < kLeastAgreement) {
      process_.Warn(
          "dense_disagrees",
          fmt::format("dense depth agrees with {:.0f} % of the points of a keyframe: surfaces will have holes and "
                      "errors; check the calibration with `plslam rectify-check`",
                      100.0 * depth.agreement));
    }
    if (!map_) BeginMap(DenseMap(VoxelFor(keyframe), options_.range_m));
    map_->Add({keyframe.name.session, keyframe.frame_id}, depth, left, camera_->rectifier.camera(), poses);
    SurfacesChanged();
    disk_.Fused(*map_, sparse_->follower().map());
    process_.SetCounter("depth_ms", matched_ms - began_ms);
    process_.SetCounter("fusion_ms", bus::NowMs() - matched_ms);
    process_.SetCounter("depth.offset_px", depth.offset_px);
    process_.SetCounter("depth.sigma_scale", depth.sigma_scale);
    process_.SetCounter("keyframes", static_cast<double>(map_->n_keyframes()));
    process_.SetCounter("submaps", static_cast<double>(map_->n_submaps()));
    process_.SetCounter("map_mb", 1e-6 * static_cast<double>(map_->bytes()));
    process_.SetCounter("map_kb_per_m3", 1e-3 * map_->BytesPerCubicMetre());
    process_.SetState(process_state::kRunning);
  } catch (const std::exception& error) {
    LogWarning("frame {} is not used for surfaces: {}", keyframe.frame_id, error.what());
    process_.SetCounter("keyframes.bad", static_cast<double>(++n_bad_));
  }
}

/// The edge of a voxel for the scene of the first keyframe, unless it is given.
double DenseNode::VoxelFor(const Keyframe& keyframe) const {
  if (options_.voxel_m > 0.0) return options_.voxel_m;
  std::vector<double> depths_m;
  for (const StereoPoint& point : keyframe.features.points) {
    if (point.HasDepth()) depths_m.push_back(keyframe.camera.Depth(point.disparity_px));
  }
  const bool is_road = !depths_m.empty() && Median(depths_m) >= kIndoors_m;
  return std::min(is_road ? kRoadVoxel_m : kIndoorVoxel_m, LargestVoxelFor(options_.robot_height_m));
}

void DenseNode::FollowRemovals(const KeyframePoses& poses) {
  if (!camera_) return;
  const Map& map = sparse_->follower().map();
  const KeyframePoses lasting = LastingPosesOf(map);
  map_->FollowRemovals(poses, lasting, camera_->rectifier.camera());
  if (poses.size() <= lasting.size() + kMostRemoved) return;
  sparse_->ForgetRemoved(RemovedToForget(map.RemovedKeyframes(), kMostRemoved, map_->Members()));
}

void DenseNode::SurfacesChanged() {
  dirty_ = true;
  live_.Outdate();
}

void DenseNode::OnTick() {
  FuseAll();  // keyframes may have waited for the camera of their images
  PublishLive();
  end_.OnTick();
  if ((!dirty_ && finished_) || !end_.IsOver(received_, sparse_->follower().newest())) return;
  Write();
  finished_ = true;
  disk_.failure().empty() ? process_.SetState(process_state::kFinished, "files in " + options_.out)
                          : process_.SetState(process_state::kFailed, disk_.failure());
}

void DenseNode::PublishLive() {
  const double now_ms = bus::NowMs();
  if (map_ && live_.IsDue(now_ms)) {
    process_.SetCounter("grid_ms", live_.Publish(*map_, sparse_->follower().map(), now_ms));
    CountPublished();
  }
}

void DenseNode::CountPublished() {
  process_.SetCounter(dense_counter::kTiles, static_cast<double>(live_.n_tiles()));
  process_.SetCounter(dense_counter::kSubmaps, static_cast<double>(live_.n_submaps()));
}

void DenseNode::Write() {
  dirty_ = false;
  const Map& map = sparse_->follower().map();
  const size_t n_missing = CountMissing(map);
  if (!map_) {
    if (n_missing > 0) {
      disk_.SetFailure(fmt::format("no surfaces: no keyframe of {} was received with its images", n_missing));
    }
    return;
  }
  try {
    const KeyframePoses poses = PosesOf(map);
    FollowRemovals(poses);
    const Vertical vertical = VerticalWithSurfaces(*map_, poses, VerticalOf(map, options_.up));
    const Products products =
        MakeProducts(*map_, poses, vertical, PathOf(poses, map_->voxel_m()), options_.robot_height_m);
    std::string failure = products.no_grid;
    for (const auto& [name, kind] : kProductKinds) {
      if (kind == ProductKind::kMeshObj) continue;
      try {
        WriteProducts(options_.out, products, kind);
      } catch (const std::exception& error) {
        if (failure.empty()) failure = error.what();
      }
    }
    live_.PublishFinal(products, map_->Split(products.surface, poses));
    CountPublished();
    WriteFrames(options_.out, products);
    LogInfo(
        "surfaces of {} keyframes: {} triangles; grid of {} x {} cells of {} m; {:.1f} MB, {:.0f} kB per m3 of space",
        map_->n_keyframes(), products.surface.triangles.size(), products.grid.cells.cols, products.grid.cells.rows,
        map_->voxel_m(), 1e-6 * static_cast<double>(map_->bytes()), 1e-3 * map_->BytesPerCubicMetre());
    if (!products.has_floor) {
      process_.Warn("no_floor", "no grid is written: the map has no horizontal surface that could be the floor");
    }
    if (products.has_floor && vertical.source == VerticalSource::kCameras) {
      process_.Warn(
          "vertical_guessed",
          "the vertical of the grid is the mean of the cameras' up, a guess: neither lines nor surfaces nor an "
          "inertial sensor show one; state how the camera is mounted (dense.up, up in the camera's own frame)");
    }
    disk_.SetFailure(failure);
    if (const size_t n_unplaced = map_->CountUnplaced(poses); n_unplaced > 0) {
      process_.Warn("surfaces_unplaced",
                    fmt::format("{} of {} submaps are not in the files: the map has none of their keyframes (it is "
                                "another map, or was saved before them)",
                                n_unplaced, map_->n_submaps()));
    }
    if (n_missing > 0) {
      process_.Warn(
          "surfaces_missing",
          fmt::format("{} keyframes are not in the surfaces: dense_process did not receive their images (it "
                      "started later, or was killed), or was too slow for a live stream",
                      n_missing));
    }
  } catch (const std::exception& error) {
    disk_.SetFailure(error.what());
  }
}

/// Images are not resent to a process that starts late, or replaces one that was killed; live, the oldest are dropped.
/// Sessions without any surfaces were mapped without this process, or by another robot.
size_t DenseNode::CountMissing(const Map& map) const {
  return static_cast<size_t>(std::ranges::count_if(LastingPosesOf(map), [this](const auto& keyframe) {
    return !map_ || (map_->HasSession(keyframe.first.first) && !map_->Has(keyframe.first));
  }));
}

bus::ProcessSpec DenseSpec() {
  bus::ProcessSpec spec;
  spec.name = process_name::kDense;
  spec.description = "Surfaces for planning: images of keyframes in, mesh, cloud, OctoMap and grid out.";
  spec.examples =
      "  dense_process --set dense.out=map\n"
      "  dense_process --set dense.voxel_m=0.1 --set dense.robot_height_m=0.5";
  spec.make_node = bus::NodeWithOptions<DenseNode, DenseOptions>(spec.name);
  spec.waits_for = "keyframes of vo_process and a map of mapping_process";
  spec.results = {{"keyframes", "keyframes fused"}, {"submaps", "submaps"}};
  return spec;
}

}  // namespace plslam::dense
