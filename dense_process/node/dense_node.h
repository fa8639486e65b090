// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/geometry/rectifier.h"
#include "core/ids/ids.h"
#include "core/process/order.h"
#include "core/process/process.h"
#include "core/run/node/run_end.h"
#include "dense_process/dense_map.h"
#include "dense_process/depth.h"
#include "dense_process/node/live_products.h"
#include "dense_process/node/surfaces_on_disk.h"
#include "dense_process/options.h"
#include "dense_process/waiting_keyframes.h"

namespace plslam {
class command_answer_t;
class command_t;
class mask_t;
class status_t;
class stream_t;
class tracks_t;
}  // namespace plslam

namespace plslam::dense {

/// Fuses the images of keyframes into surfaces, and writes them when the run is over (`RunEnd`; state "finished"); again
/// when it is stopped and something has changed since.
///
/// A keyframe waits for its images, its features and its place in the map. In lockstep all are delivered, so results are
/// repeatable, and the player waits if this process is three frames behind. Live, no other process waits for it: the
/// oldest waiting keyframes are dropped if too many wait, and counted.
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

  void CheckOptions() const;
  double VoxelFor(const Keyframe& keyframe) const;
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
  void OnCommandAnswer(const command_answer_t& message);
  void BeginMap(DenseMap map);
  void OnTick();

  void FuseAll();
  void Fuse(const ReadyKeyframe& ready, const KeyframePoses& poses);
  cv::Mat PixelsInUse(const ReadyKeyframe& ready, const cv::Size& size) const;
  DepthImage DepthOf(const ReadyKeyframe& ready, const cv::Mat& left) const;
  void FollowRemovals(const KeyframePoses& poses);
  void SurfacesChanged();
  void PublishLive();
  void CountPublished();
  void Write();
  size_t CountMissing(const Map& map) const;

  bus::Process& process_;
  DenseOptions options_;
  std::optional<Camera> camera_;
  std::optional<DenseMap> map_;
  std::optional<MapId> map_id_;  ///< of the newest update
  /// Orders to mapping_process to save the map, and the newest one to load another, until the map is replaced.
  std::map<std::pair<SourceId, int64_t>, bus::Order> saves_;
  std::optional<bus::Order> load_;
  WaitingKeyframes waiting_;
  RunEnd end_{process_.has_launcher()};
  RunEnd::Received received_;
  SurfacesOnDisk disk_;
  LiveProducts live_;
  bool dirty_ = false;  ///< the surfaces have changed since the results were written
  bool finished_ = false;
  int64_t n_bad_ = 0;
  std::unique_ptr<bus::MapSubscriber> sparse_;
  // Last, because their handlers use all of the above.
  std::optional<bus::CameraSubscriber> camera_channel_;
  std::optional<bus::KeyframeSubscriber> keyframes_;
  std::optional<bus::FrameSubscriber> images_;
};

bus::ProcessSpec DenseSpec();

}  // namespace plslam::dense
