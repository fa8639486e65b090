// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/node/dense_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/errors/standard_streams.h"
#include "core/geometry/image_mask.h"
#include "core/map/vertical.h"
#include "core/motion/robust.h"
#include "core/process/order.h"
#include "core/run/process_names.h"
#include "dense_process/products.h"
#include "plslam/command_t.hpp"
#include "plslam/mask_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "plslam/tracks_t.hpp"

namespace plslam::dense {
namespace {

constexpr std::chrono::milliseconds kTick(250);
// Ticks without a message after which a run that has ended is complete.
constexpr int kQuietTicks = 2;
// Ticks after which the map counts as complete although the last keyframe is not committed: mapping_process has exited.
constexpr int kQuietTicksForTheMap = 240;
// A tracker announces the keyframe of a frame before it tracks the next one; live, a few frames later.
constexpr size_t kMostFrames = 12;
constexpr size_t kMostWaiting = 24;
// The median depth of the points of the first keyframe that separates rooms from roads, and the voxels of both.
constexpr double kIndoors_m = 8.0;
constexpr double kIndoorVoxel_m = 0.05;
constexpr double kRoadVoxel_m = 0.2;
// Below this share of points with the same disparity as in the keyframe the pair does not fit its calibration.
constexpr double kLeastAgreement = 0.6;
constexpr int kLeastCompared = 50;
// The state is written after so many keyframes, and when the map has grown by a quarter: its cost is in proportion to the
// map.
constexpr size_t kStateEvery = 10;
constexpr double kLeastGridInterval_ms = 2000.0;
// Cosine of the angle of two verticals that are the same for the published grid: 0.3 degrees.
constexpr double kSameVertical = 1.0 - 1.4e-5;

double VoxelFor(const Keyframe& keyframe) {
  std::vector<double> depths_m;
  for (const StereoPoint& point : keyframe.features.points) {
    if (point.HasDepth()) depths_m.push_back(keyframe.camera.Depth(point.disparity_px));
  }
  if (depths_m.empty()) return kIndoorVoxel_m;
  return Median(depths_m) < kIndoors_m ? kIndoorVoxel_m : kRoadVoxel_m;
}

template <class Value>
void KeepNewest(std::map<FrameId, Value>& values) {
  while (values.size() > kMostFrames) values.erase(values.begin());
}

}  // namespace

DenseNode::DenseNode(bus::Process& process, const DenseOptions& options)
    : process_(process), options_(options), grid_(process.bus()) {
  std::filesystem::create_directories(options_.out);
  // One thread: the tracker needs the other core.
  cv::setNumThreads(1);
  bus::Bus& bus = process_.bus();
  bus.Subscribe<stream_t>(bus::kStream, [this](const stream_t& m) { OnStream(m); });
  bus.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
  bus.Subscribe<command_t>(bus::kCommand, [this](const command_t& m) { OnCommand(m); });
  bus.Subscribe<tracks_t>(bus::kTracks, [this](const tracks_t& m) { OnTracks(m); });
  bus.Subscribe<tracks_t>(bus::kTracksLive, [this](const tracks_t& m) { OnTracks(m); });
  bus.Subscribe<mask_t>(bus::kMask, [this](const mask_t& m) { OnMask(m); });
  sparse_ = std::make_unique<bus::MapSubscriber>(bus, [this](const MapUpdate& update) { OnMap(update); });
  sparse_->RememberRemoved();
  camera_channel_.emplace(bus, [this](const RigCalibration& rig) { OnCamera(rig); });
  keyframes_.emplace(bus, [this](const Keyframe& keyframe) { OnKeyframe(keyframe); });
  images_.emplace(bus, bus::FrameSubscriber::Mode::kPictures, [this](const auto& frame) { OnFrame(frame); });
  bus.Every(kTick, [this] { OnTick(); });
  process_.SetConfiguration(ToYaml("dense", options_));
  const bool has_state = !options_.state_file.empty() && std::filesystem::exists(options_.state_file);
  const std::string& earlier = has_state ? options_.state_file : options_.map_file;
  if (earlier.empty()) return;
  map_ = DenseMap::Read(earlier, options_.range_m);
  LogInfo("continuing the surfaces of {} keyframes in {}", map_->n_keyframes(), earlier);
}

DenseNode::~DenseNode() {
  if (std::uncaught_exceptions() == 0) {
    if (dirty_) Write();
    KeepState();
  }
  const std::string failure = Joined(failure_, save_failure_);
  if (failure.empty()) return;
  PrintError(fmt::format("{}: error: {}", process_.name(), failure));
  process_.Finish(1);
}

void DenseNode::OnCamera(const RigCalibration& rig) {
  try {
    camera_.emplace(Camera{rig, Rectifier(rig)});
  } catch (const std::exception& error) {
    LogWarning("the rig '{}' cannot be used: {}", rig.name, error.what());
  }
  FuseAll();
}

void DenseNode::OnFrame(const bus::FrameSubscriber::Frame& frame) {
  quiet_ticks_ = 0;
  const FrameId frame_id = frame.images.frame_id;
  for (auto& [name, waiting] : waiting_) {
    if (!waiting.images && waiting.keyframe.frame_id == frame_id && waiting.keyframe.t_ns == frame.images.t_ns) {
      waiting.images = frame.images;
      return FuseAll();
    }
  }
  frames_[frame_id] = frame.images;
  KeepNewest(frames_);
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
  bodies_[FrameId(message.frame_id)] = std::move(bodies);
  KeepNewest(bodies_);
}

void DenseNode::OnMask(const mask_t& message) {
  const std::optional<FrameMask> mask = bus::FromMessage(message);
  if (!mask) return process_.bus().CountRejected();
  masks_[FrameId(message.frame_id)] = *mask;
  KeepNewest(masks_);
}

void DenseNode::OnKeyframe(const Keyframe& keyframe) {
  quiet_ticks_ = 0;
  newest_ = keyframe.name;
  // The histories resend keyframes that a process before this one has fused.
  if (map_ && map_->Has({keyframe.name.session, keyframe.frame_id})) return;
  Waiting waiting{keyframe, std::nullopt};
  const auto frame = frames_.find(keyframe.frame_id);
  if (frame != frames_.end() && frame->second.t_ns == keyframe.t_ns) {
    waiting.images = std::move(frame->second);
    frames_.erase(frame);
  }
  waiting_.insert_or_assign({keyframe.name.session, keyframe.frame_id}, std::move(waiting));
  DropOldest();
  FuseAll();
}

/// Keyframes that were made before this process started have no images. In lockstep all others stay: they wait for the
/// map alone, and the results of a run do not depend on its times.
void DenseNode::DropOldest() {
  while (waiting_.size() > kMostWaiting) {
    auto dropped = std::ranges::find_if(waiting_, [](const auto& w) { return !w.second.images.has_value(); });
    const bool lacks = dropped != waiting_.end();
    if (!lacks) dropped = std::ranges::find_if(waiting_, [](const auto& w) { return !w.second.keyframe.lockstep; });
    if (dropped == waiting_.end()) return;
    process_.SetCounter(lacks ? "keyframes.without_images" : "keyframes.dropped",
                        static_cast<double>(++(lacks ? n_without_images_ : n_dropped_)));
    waiting_.erase(dropped);
  }
}

void DenseNode::OnMap(const MapUpdate& update) {
  quiet_ticks_ = 0;
  FollowMap(update.map_id);
  // A correction moves the surfaces.
  if (map_ && map_->n_keyframes() > 0) dirty_ = grid_is_old_ = true;
  FuseAll();
}

/// Another map replaces the surfaces, too; a rebuilt one has the same keyframes.
void DenseNode::FollowMap(const MapId& map) {
  const std::optional<MapId> before = std::exchange(map_id_, map);
  if (!before || map.Matches(*before)) return;
  LogInfo("the map was replaced: its surfaces are dropped");
  map_.reset();
  waiting_.clear();
}

void DenseNode::OnStatus(const status_t& message) {
  if (message.process == process_name::kVo) vo_finished_ = message.state == process_state::kFinished;
}

void DenseNode::OnStream(const stream_t& message) {
  ended_ = message.event == stream_event::kEnd;
  quiet_ticks_ = 0;
}

void DenseNode::OnCommand(const command_t& message) {
  const std::optional<bus::Order> order = bus::OrderTo(process_, message);
  if (order && order->verb == command_verb::kFinish) process_.Finish();
  // An order to mapping_process, which answers it.
  if (message.verb != command_verb::kSave || message.target != process_name::kMapping || !map_) return;
  try {
    WriteSurfaces(bus::ToSaveRequest(message.argument).file + ".surfaces");
  } catch (const std::exception& error) {
    save_failure_ = error.what();
  }
}

/// Beside a saved map, or as the state.
void DenseNode::WriteSurfaces(const std::string& path) {
  const Map& map = sparse_->follower().map();
  map_->Write(path, PosesOf(map), LastingPosesOf(map));
}

/// If writing fails the process continues, with a higher cost of a crash.
void DenseNode::KeepState() {
  if (!map_ || options_.state_file.empty() || n_since_state_ == 0) return;
  n_since_state_ = 0;
  try {
    WriteSurfaces(options_.state_file);
  } catch (const std::exception& error) {
    if (!std::exchange(state_failed_, true)) LogWarning("the state for a restart is not written: {}", error.what());
  }
}

/// In lockstep a keyframe is fused as soon as it is committed; live, as soon as the map has it.
void DenseNode::FuseAll() {
  if (!camera_ || waiting_.empty()) return;
  const KeyframePoses poses = PosesOf(sparse_->follower().map());
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    const Waiting& waiting = it->second;
    const bool placed =
        !waiting.keyframe.lockstep || sparse_->follower().newest().HasCommitted(waiting.keyframe.name);
    if (!waiting.images || !placed || !poses.contains(it->first)) {
      ++it;
      continue;
    }
    Fuse(waiting, poses);
    it = waiting_.erase(it);
  }
}

/// Without the masks of the rig and of the frame, and without moving bodies.
cv::Mat DenseNode::PixelsInUse(FrameId frame_id, const cv::Size& size) const {
  cv::Mat in_use = camera_->rectifier.left_mask();
  const auto mask = masks_.find(frame_id);
  if (mask != masks_.end() && !mask->second.left.empty()) {
    CameraCalibration left = camera_->rig.left;
    left.mask = mask->second.left;
    in_use = camera_->rectifier.LeftMask(DrawMask(left));
  }
  const auto bodies = bodies_.find(frame_id);
  return bodies == bodies_.end() ? in_use : MaskBodies(in_use, size, bodies->second);
}

DepthImage DenseNode::DepthOf(const Waiting& waiting, const cv::Mat& left) const {
  const Rectifier& rectifier = camera_->rectifier;
  const StereoImages& images = *waiting.images;
  const cv::Mat in_use = PixelsInUse(waiting.keyframe.frame_id, left.size());
  if (camera_->rig.kind == RigCalibration::Kind::kStereo) {
    return MatchPair(left, rectifier.RectifyRight(images.right), in_use, rectifier.camera(),
                     waiting.keyframe.features);
  }
  DepthImage depth = FromSensor(rectifier.RectifyDepth(images.right), camera_->rig.depth_units_per_m);
  if (!in_use.empty()) depth.z_m.setTo(0.0, in_use == 0);
  return depth;
}

void DenseNode::Fuse(const Waiting& waiting, const KeyframePoses& poses) {
  const double began_ms = bus::NowMs();
  const Keyframe& keyframe = waiting.keyframe;
  try {
    const cv::Mat left = camera_->rectifier.RectifyLeft(waiting.images->left);
    const DepthImage depth = DepthOf(waiting, left);
    const double matched_ms = bus::NowMs();
    if (depth.n_compared >= kLeastCompared && depth.agreement < kLeastAgreement) {
      process_.Warn(
          "dense_disagrees",
          fmt::format("dense depth agrees with {:.0f} % of the points of a keyframe: surfaces will have holes and "
                      "errors; check the calibration with `plslam rectify-check`",
                      100.0 * depth.agreement));
    }
    if (!map_) map_.emplace(options_.voxel_m > 0.0 ? options_.voxel_m : VoxelFor(keyframe), options_.range_m);
    map_->Add({keyframe.name.session, keyframe.frame_id}, depth, left, camera_->rectifier.camera(), poses);
    dirty_ = grid_is_old_ = true;
    if (++n_since_state_ >= std::max<size_t>(kStateEvery, map_->n_keyframes() / 4)) KeepState();
    process_.SetCounter("depth_ms", matched_ms - began_ms);
    process_.SetCounter("fusion_ms", bus::NowMs() - matched_ms);
    process_.SetCounter("depth.offset_px", depth.offset_px);
    process_.SetCounter("depth.sigma_scale", depth.sigma_scale);
    process_.SetCounter("keyframes", static_cast<double>(map_->n_keyframes()));
    process_.SetCounter("submaps", static_cast<double>(map_->n_submaps()));
    process_.SetCounter("map_mb", 1e-6 * static_cast<double>(map_->bytes()));
    process_.SetState(process_state::kRunning);
  } catch (const std::exception& error) {
    LogWarning("frame {} is not used for surfaces: {}", keyframe.frame_id, error.what());
    process_.SetCounter("keyframes.bad", static_cast<double>(++n_bad_));
  }
}

bool DenseNode::IsOver() const {
  if (!ended_ || quiet_ticks_ <= kQuietTicks) return false;
  const bool complete = vo_finished_ && newest_ && sparse_->follower().newest().HasCommitted(*newest_);
  return complete || quiet_ticks_ > kQuietTicksForTheMap;
}

void DenseNode::OnTick() {
  PublishGrid();
  ++quiet_ticks_;
  if ((!dirty_ && finished_) || !IsOver()) return;
  Write();
  finished_ = true;
  failure_.empty() ? process_.SetState(process_state::kFinished, "files in " + options_.out)
                   : process_.SetState(process_state::kFailed, failure_);
}

/// Live, for robots and viewers, in at most a tenth of the time of this process.
void DenseNode::PublishGrid() {
  const double began_ms = bus::NowMs();
  if (!grid_is_old_ || !map_ || began_ms < next_grid_ms_) return;
  grid_is_old_ = false;
  try {
    const Map& map = sparse_->follower().map();
    const KeyframePoses poses = PosesOf(map);
    // Small changes of the vertical would change all cells.
    const Vertical vertical = VerticalOf(map);
    if (!grid_vertical_ || vertical.up_w.dot(grid_vertical_->up_w) < kSameVertical) grid_vertical_ = vertical;
    const Products products =
        MakeProducts(*map_, poses, *grid_vertical_, PathOf(poses, 0.5 * map_->voxel_m()), options_.robot_height_m);
    if (products.has_floor) grid_.Publish(ToOccupancyGrid(products));
  } catch (const std::exception& error) {
    LogWarning("no grid is published: {}", error.what());
  }
  const double took_ms = bus::NowMs() - began_ms;
  process_.SetCounter("grid_ms", took_ms);
  next_grid_ms_ = began_ms + std::max(kLeastGridInterval_ms, 10.0 * took_ms);
}

void DenseNode::Write() {
  dirty_ = false;
  const Map& map = sparse_->follower().map();
  const size_t n_missing = CountMissing(map);
  if (!map_) {
    if (n_missing > 0)
      failure_ = fmt::format("no surfaces: no keyframe of {} was received with its images", n_missing);
    return;
  }
  try {
    const KeyframePoses poses = PosesOf(map);
    const Products products =
        MakeProducts(*map_, poses, VerticalOf(map), PathOf(poses, 0.5 * map_->voxel_m()), options_.robot_height_m);
    for (const auto& [name, kind] : kProductKinds) WriteProducts(options_.out, products, kind);
    if (products.has_floor) grid_.Publish(ToOccupancyGrid(products));
    grid_is_old_ = false;
    WriteFrames(options_.out, products);
    LogInfo("surfaces of {} keyframes: {} triangles; grid of {} x {} cells of {} m", map_->n_keyframes(),
            products.surface.triangles.size(), products.grid.cells.cols, products.grid.cells.rows, map_->voxel_m());
    if (!products.has_floor) {
      process_.Warn("no_floor", "no grid is written: the map has no horizontal surface that could be the floor");
    }
    failure_.clear();
    if (n_missing > 0) {
      process_.Warn(
          "surfaces_missing",
          fmt::format("{} keyframes are not in the surfaces: dense_process did not receive their images (it "
                      "started later, or was killed), or was too slow for a live stream",
                      n_missing));
    }
  } catch (const std::exception& error) {
    failure_ = error.what();
  }
}

/// Images are not resent to a process that starts late, or replaces one that was killed; live, the oldest are dropped.
size_t DenseNode::CountMissing(const Map& map) const {
  return static_cast<size_t>(std::ranges::count_if(
      LastingPosesOf(map), [this](const auto& keyframe) { return !map_ || !map_->Has(keyframe.first); }));
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
