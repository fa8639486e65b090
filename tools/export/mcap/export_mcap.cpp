// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/mcap/export_mcap.h"

#include <algorithm>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors/error_text.h"
#include "core/io/images/image_header.h"
#include "core/io/images/jpeg_codec.h"
#include "core/robot/body_pose.h"
#include "core/ros/level_frame.h"
#include "core/ros/ros_definitions.h"
#include "core/ros/ros_messages.h"
#include "core/ros/ros_topics.h"
#include "core/run/tracking_state.h"
#include "tools/export/cloud_file.h"
#include "tools/export/grid_files.h"
#include "tools/export/mcap/mcap_writer.h"
#include "tools/pose_graph/export.h"

namespace plslam::exports {
namespace {

using nlohmann::json;

json ScenePanel() {
  json topics = json::object();
  for (const char* topic : {"/map/points", "/map/lines", "/loops", "/path", "/path_truth", "/odom"}) {
    topics[topic] = {{"visible", true}};
  }
  topics["/map/points"].update({{"pointSize", 2}, {"colorMode", "rgb"}, {"colorField", "rgb"}});
  topics["/path"].update({{"type", "line"}, {"lineWidth", 0.02}, {"gradient", {"#6bdcec", "#6bdcec"}}});
  topics["/path_truth"].update({{"type", "line"}, {"lineWidth", 0.01}, {"gradient", {"#7fbf3f", "#7fbf3f"}}});
  for (const char* topic : {"/path_live", "/keyframes"}) topics[topic] = {{"visible", false}};
  topics["/camera/left/camera_info"] = {{"visible", true}, {"distance", 0.5}};
  return {{"followMode", "follow-none"},
          {"followTf", kRosWorld},
          {"scene", {{"transforms", {{"axisScale", 0.3}, {"labelSize", 0}}}}},
          {"topics", topics},
          {"layers", {{"grid", {{"layerId", "foxglove.Grid"}, {"instanceId", "grid"}, {"visible", true}}}}}};
}

json PlotPanel() {
  json paths = json::array();
  for (const char* path : {"/odom.twist.twist.linear.z", "/odom.twist.twist.angular.y"}) {
    paths.push_back({{"value", path}, {"enabled", true}, {"timestampMethod", "headerStamp"}});
  }
  return {{"paths", paths}, {"showLegend", true}, {"xAxisVal", "timestamp"}, {"isSynced", true}};
}

}  // namespace

std::string FoxgloveLayout() {
  const json image = {
      {"imageMode", {{"imageTopic", "/camera/left/compressed"}, {"calibrationTopic", "/camera/left/camera_info"}}}};
  const json side = {
      {"direction", "column"},
      {"first", "Image!plslam"},
      {"second", {{"direction", "column"}, {"first", "Plot!plslam"}, {"second", "DiagnosticSummary!plslam"}}},
      {"splitPercentage", 40}};
  const json layout = {
      {"configById",
       {{"3D!plslam", ScenePanel()},
        {"Image!plslam", image},
        {"Plot!plslam", PlotPanel()},
        {"DiagnosticSummary!plslam", {{"topicToRender", "/diagnostics"}}}}},
      {"globalVariables", json::object()},
      {"userNodes", json::object()},
      {"playbackConfig", {{"speed", 1}}},
      {"layout", {{"direction", "row"}, {"first", "3D!plslam"}, {"second", side}, {"splitPercentage", 65}}}};
  return layout.dump(2) + "\n";
}

namespace {

constexpr int kJpegQuality = 80;

/// The writer, and its channels by topic: a topic is added with its first message.
class Topics {
 public:
  explicit Topics(const std::string& path) : writer_(path) {}

  void Write(const RosTopic& topic, int64_t t_ns, const std::string& cdr) {
    const auto [place, is_new] = channels_.try_emplace(std::string(topic.name), uint16_t{0});
    const std::string type(topic.type);
    if (is_new) place->second = writer_.AddChannel(place->first, type, RosDefinition(type));
    writer_.Write(place->second, t_ns, cdr);
  }
  void Close() { writer_.Close(); }

 private:
  McapWriter writer_;
  std::map<std::string, uint16_t> channels_;
};

/// A message to write and its time. Messages are created one at a time to bound memory.
struct MessageToWrite {
  int64_t t_ns;
  std::function<void()> write;
};

/// Velocity in l from the pose before, and the covariance of the motion as one of the velocity.
void SetVelocity(const TrajectoryPose& before, const Matrix6d& motion_covariance, RosOdometry& odometry) {
  const double seconds = 1e-9 * static_cast<double>(odometry.t_ns - before.t_ns);
  odometry.velocity = (before.T_a_b.Inverse() * odometry.T_parent_child).Log() / seconds;
  odometry.velocity_covariance = motion_covariance / (seconds * seconds);
}

/// An image file as readers of ROS messages open it.
struct CompressedImage {
  std::string format;
  std::string bytes;
};

/// Returns the file unchanged if it is a complete JPEG or an 8-bit PNG; nullopt if the image has to be encoded.
std::optional<CompressedImage> FileAsRecorded(const std::string& path) {
  static constexpr size_t kPngBitDepth = 24;
  if (path.empty()) return std::nullopt;
  std::ifstream file = OpenInput(path);
  std::string bytes(std::filesystem::file_size(path), '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return std::nullopt;
  const std::span view(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  const auto header = ParseImageHeader(view);
  if (!header || !IsComplete(*header, view)) return std::nullopt;
  if (header->format == ImageFormat::kJpeg) return CompressedImage{"jpeg", std::move(bytes)};
  const bool is_plain_png = header->format == ImageFormat::kPng && view[kPngBitDepth] == 8;
  if (!is_plain_png) return std::nullopt;
  return CompressedImage{"png", std::move(bytes)};
}

/// Left images as they are written, in the order in which they were added. A few are encoded ahead, each on a separate
/// thread.
class ImagesAhead {
 public:
  explicit ImagesAhead(const Dataset& dataset) : dataset_(dataset) {}

  void Add(int index) { indices_.push_back(index); }
  bool empty() const { return indices_.empty(); }

  CompressedImage Next() {
    const size_t n_ahead = std::max(2U, std::thread::hardware_concurrency());
    while (n_begun_ < indices_.size() && begun_.size() < n_ahead) Begin(indices_[n_begun_++]);
    CompressedImage image = begun_.front().get();
    begun_.pop_front();
    return image;
  }

 private:
  void Begin(int index) {
    begun_.push_back(std::async(std::launch::async, [this, index] {
      if (auto recorded = FileAsRecorded(dataset_.LeftFile(index))) return *std::move(recorded);
      return CompressedImage{"jpeg", EncodeJpeg(Read(index), kJpegQuality)};
    }));
  }

  cv::Mat Read(int index) {
    const std::lock_guard lock(reading_);
    return dataset_.Read(index).left;
  }

  const Dataset& dataset_;
  std::vector<int> indices_;
  size_t n_begun_ = 0;
  std::mutex reading_;  // datasets are read by one at a time
  std::deque<std::future<CompressedImage>> begun_;
};

std::vector<RosDiagnostic> DiagnosticsOf(const FrameTable& table) {
  std::vector<RosDiagnostic> frames;
  for (const FrameTable::Row& row : table.rows) {
    const std::string& state = row.values[FrameTable::kState];
    const int level = state == TrackingStateName(TrackingState::kLost)       ? 2
                      : state == TrackingStateName(TrackingState::kTracking) ? 0
                                                                             : 1;
    RosDiagnostic frame{row.t_ns, level, "vo_process", state, {}};
    for (size_t i = 0; i < row.values.size(); ++i) {
      if (i != FrameTable::kTime && i != FrameTable::kState)
        frame.values.emplace_back(table.columns[i], row.values[i]);
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

/// Returns the covariance of that time; null if there is none.
const Matrix6d* Find(const std::optional<std::vector<PoseCovariance>>& covariances, int64_t t_ns) {
  if (!covariances) return nullptr;
  const auto found = std::ranges::lower_bound(*covariances, t_ns, {}, &PoseCovariance::t_ns);
  return found != covariances->end() && found->t_ns == t_ns ? &found->covariance : nullptr;
}

class Exporter {
 public:
  Exporter(const Run& run, const Dataset* dataset, const std::string& path)
      : run_(run),
        dataset_(dataset),
        topics_(path),
        poses_(run.trajectory.value_or(Trajectory())),
        frames_(run.frames ? DiagnosticsOf(*run.frames) : std::vector<RosDiagnostic>()) {
    if (dataset != nullptr) images_.emplace(*dataset);
  }

  McapContent Write() {
    AddWhole();
    AddFrames();
    AddImages();
    for (const RosDiagnostic& frame : frames_) {
      At(frame.t_ns, [&] { topics_.Write(ros_topic::kDiagnostics, frame.t_ns, RosDiagnosticMessage(frame)); });
    }
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const MessageToWrite& a, const MessageToWrite& b) { return a.t_ns < b.t_ns; });
    for (const MessageToWrite& message : messages_) message.write();
    topics_.Close();
    return content_;
  }

 private:
  void At(int64_t t_ns, std::function<void()> write) { messages_.push_back({t_ns, std::move(write)}); }

  /// Returns the time of the first message: data of the whole run are written at the beginning.
  int64_t Begin() const {
    int64_t begin = poses_.empty() ? INT64_MAX : poses_.front().t_ns;
    if (!frames_.empty()) begin = std::min(begin, frames_.front().t_ns);
    if (begin == INT64_MAX && run_.map && !run_.map->map.keyframes().empty()) {
      begin = run_.map->map.keyframes().begin()->second.t_ns;
    }
    return begin == INT64_MAX ? 0 : begin;
  }

  void AddPath(const RosTopic& topic, const Trajectory& trajectory, int64_t t_ns) {
    if (trajectory.empty()) return;
    At(t_ns, [=, this] { topics_.Write(topic, t_ns, RosPath(t_ns, topic.frame, trajectory)); });
  }

  void AddWhole() {
    const int64_t t = Begin();
    At(t, [=, this] {
      topics_.Write(
          ros_topic::kTfStatic, t,
          RosTransforms(t, {{kRosWorld, kRosMap, run_.map ? LevelFromMap(run_.map->map) : LevelFromCamera()}}));
    });
    AddPath(ros_topic::kPath, poses_, t);
    if (run_.live) AddPath(ros_topic::kPathLive, *run_.live, t);
    if (run_.truth) AddPath(ros_topic::kPathTruth, *run_.truth, t);
    if (const auto grid = run_.folder.empty() ? std::nullopt : ReadGridFiles(run_.folder)) {
      content_.has_grid = true;
      At(t, [=, this] { topics_.Write(ros_topic::kGrid, t, RosOccupancyGrid(t, *grid)); });
    }
    if (auto cloud = run_.folder.empty() ? std::nullopt : ReadCloudFile(run_.folder)) {
      content_.has_surfaces = true;
      At(t,
         [t, this, points = std::move(*cloud)] { topics_.Write(ros_topic::kSurfaces, t, RosSurfaces(t, points)); });
    }
    if (!run_.map) return;
    content_.has_map = true;
    At(t, [=, this] { WriteMap(t, run_.map->map); });
  }

  void WriteMap(int64_t t, const Map& map) {
    topics_.Write(ros_topic::kMapPoints, t, RosPoints(t, map));
    topics_.Write(ros_topic::kMapLines, t, RosLines(t, map));
    topics_.Write(ros_topic::kLoops, t, RosLoops(t, map));
    Trajectory keyframes;
    for (const auto& [id, keyframe] : map.keyframes()) keyframes.push_back({keyframe.t_ns, keyframe.T_w_kf});
    topics_.Write(ros_topic::kKeyframes, t, RosPoseArray(t, kRosMap, keyframes));
  }

  void AddFrames() {
    for (size_t i = 0; i < poses_.size(); ++i) At(poses_[i].t_ns, [=, this] { WriteFrame(i); });
    content_.frames = static_cast<int64_t>(poses_.size());
  }

  void WriteFrame(size_t i) {
    const TrajectoryPose& pose = poses_[i];
    topics_.Write(ros_topic::kTf, pose.t_ns, RosTransforms(pose.t_ns, {{kRosMap, kRosCamera, pose.T_a_b}}));
    RosOdometry odometry;
    odometry.t_ns = pose.t_ns;
    odometry.T_parent_child = pose.T_a_b;
    if (const Matrix6d* covariance = Find(run_.covariance, pose.t_ns)) {
      odometry.covariance = robot::AlongParentAxes(pose.T_a_b, *covariance);
    }
    // A frame after a lost one has no motion since the previous frame.
    const Matrix6d* motion = Find(run_.motion_covariance, pose.t_ns);
    if (i > 0 && motion != nullptr) SetVelocity(poses_[i - 1], *motion, odometry);
    topics_.Write(ros_topic::kOdom, pose.t_ns, RosOdometryMessage(odometry));
    topics_.Write(ros_topic::kPose, pose.t_ns,
                  RosPoseWithCovariance(pose.t_ns, kRosMap, pose.T_a_b, odometry.covariance));
  }

  /// Adds the images that were taken during the run.
  void AddImages() {
    if (dataset_ == nullptr || poses_.empty()) return;
    const int64_t first = Begin();
    const int64_t last = std::max(poses_.back().t_ns, frames_.empty() ? 0 : frames_.back().t_ns);
    for (int i = 0; i < dataset_->size(); ++i) {
      const int64_t t = dataset_->t_ns(i);
      if (t < first || t > last || !dataset_->Missing(i).empty()) continue;
      images_->Add(i);
      At(t, [=, this] { WriteImage(t); });
      ++content_.images;
    }
    if (!images_->empty()) return;
    throw std::runtime_error(
        fmt::format("{}: has no image from the time of the run: is it another dataset?", dataset_->name()));
  }

  void WriteImage(int64_t t) {
    const CompressedImage image = images_->Next();
    topics_.Write(ros_topic::kLeftImage, t, RosCompressedImage(t, image.format, image.bytes));
    topics_.Write(ros_topic::kLeftInfo, t, RosCameraInfoMessage(t, dataset_->rig().left));
  }

  const Run& run_;
  const Dataset* dataset_;
  Topics topics_;
  const Trajectory poses_;
  const std::vector<RosDiagnostic> frames_;
  std::optional<ImagesAhead> images_;
  std::vector<MessageToWrite> messages_;
  McapContent content_;
};

}  // namespace

McapContent ExportMcap(const Run& run, const Dataset* dataset, const std::string& path) {
  return Exporter(run, dataset, path).Write();
}

}  // namespace plslam::exports
