// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/grid_channel.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/geometry/rectifier.h"
#include "core/ids/ids.h"
#include "core/map/vertical.h"
#include "core/process/process.h"
#include "dense_process/body_mask.h"
#include "dense_process/dense_map.h"
#include "dense_process/options.h"

namespace plslam {
class command_t;
class mask_t;
class status_t;
class stream_t;
class tracks_t;
}  // namespace plslam

namespace plslam::dense {

/// Fuses the images of keyframes into surfaces, and writes them when the stream has ended and the map has its last
/// keyframe (state "finished"); again when it is stopped and something has changed since.
///
/// A keyframe waits for its images, its features and its place in the map. In lockstep all are delivered, so results are
/// repeatable. Live, the oldest waiting keyframes are dropped if too many wait, and counted. No other process waits for
/// this one.
class DenseNode {
 public:
  DenseNode(bus::Process& process, const DenseOptions& options);
  ~DenseNode();
  DenseNode(const DenseNode&) = delete;
  DenseNode& operator=(const DenseNode&) = delete;

 private:
  /// The calibration in use.
  struct Camera {
    RigCalibration rig;
    Rectifier rectifier;
  };
  /// A keyframe that is not fused yet.
  struct Waiting {
    Keyframe keyframe;
    std::optional<StereoImages> images;
  };

  void OnCamera(const RigCalibration& rig);
  void OnFrame(const bus::FrameSubscriber::Frame& frame);
  void OnTracks(const tracks_t& message);
  void OnMask(const mask_t& message);
  void OnKeyframe(const Keyframe& keyframe);
  void OnMap(const MapUpdate& update);
  void FollowMap(const MapId& map);
  void OnStatus(const status_t& message);
  void OnStream(const stream_t& message);
  void OnCommand(const command_t& message);
  void OnTick();

  void FuseAll();
  void Fuse(const Waiting& waiting, const KeyframePoses& poses);
  cv::Mat PixelsInUse(FrameId frame_id, const cv::Size& size) const;
  DepthImage DepthOf(const Waiting& waiting, const cv::Mat& left) const;
  void DropOldest();
  bool IsOver() const;
  void Write();
  void PublishGrid();
  void WriteSurfaces(const std::string& path);
  void KeepState();
  size_t CountMissing(const Map& map) const;

  bus::Process& process_;
  DenseOptions options_;
  std::optional<Camera> camera_;
  std::optional<DenseMap> map_;
  std::optional<MapId> map_id_;  ///< of the newest update
  /// Newest images, pixels of moving bodies, and masks of a detector, by frame.
  std::map<FrameId, StereoImages> frames_;
  std::map<FrameId, BodyPixels> bodies_;
  std::map<FrameId, FrameMask> masks_;
  std::map<KeyframeFrame, Waiting> waiting_;
  /// Session and number of the newest keyframe.
  std::optional<KeyframeName> newest_;
  bool vo_finished_ = false;
  bool ended_ = false;
  bool dirty_ = false;
  bool finished_ = false;
  /// The grid that was published does not contain all that was fused. The next one is made at this time.
  bool grid_is_old_ = false;
  double next_grid_ms_ = 0.0;
  std::optional<Vertical> grid_vertical_;
  bus::GridPublisher grid_;
  int quiet_ticks_ = 0;
  int64_t n_dropped_ = 0;
  size_t n_since_state_ = 0;
  int64_t n_without_images_ = 0;
  int64_t n_bad_ = 0;
  std::string failure_, save_failure_;  ///< of the files of the run, and of surfaces beside a saved map
  bool state_failed_ = false;
  std::unique_ptr<bus::MapSubscriber> sparse_;
  // Last, because their handlers use all of the above.
  std::optional<bus::CameraSubscriber> camera_channel_;
  std::optional<bus::KeyframeSubscriber> keyframes_;
  std::optional<bus::FrameSubscriber> images_;
};

bus::ProcessSpec DenseSpec();

}  // namespace plslam::dense
