// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/ids/ids.h"
#include "core/process/process.h"
#include "vo_process/node/frame_inputs.h"
#include "vo_process/node/map_link.h"
#include "vo_process/node/relocalisation_client.h"
#include "vo_process/node/resend_request.h"
#include "vo_process/node/tracker_report.h"
#include "vo_process/node/tracker_state.h"
#include "vo_process/options.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/odometry.h"

namespace plslam {
class header_t;
class relocalisation_t;
class status_t;
class stream_t;
}  // namespace plslam

namespace plslam::vo {

/// vo_process on the bus.
///
/// Inputs: camera, frames, the map (`MapLink`), relocalisation results (`RelocalisationClient`), status of other
/// processes. Outputs: a pose and tracks for each frame; keyframes; relocalisation requests; go_back commands to a
/// player.
///
/// A frame is tracked when it arrives, unless the tracker waits (`Wait`), or the frame waits for its mask, the robot's
/// motion or the samples of an inertial sensor (`FrameInputs`); then up to eight frames are kept. `Wait` lists what ends each wait.
///
/// Another camera, or a time stamp that goes back by more than a second (another stream), begins a new session. A frame
/// that does not fit the camera counts as one without features, as does one of the same stream that is less than a
/// second too early (after a correction of the clock).
///
/// The map takes effect at once in a live stream. In lockstep the map of keyframe k takes effect when keyframe k + 1
/// has been made, and is awaited there; a relocalisation result takes effect before the next frame. So results do not
/// depend on timing.
///
/// With a `state_file` the state is written at each keyframe, before that is published: a tracker started after a crash
/// continues the same session with the frame after its newest keyframe. In lockstep the player sends these frames
/// again, and the results are the same, bit for bit.
///
/// In localisation-only mode (as mapping_process publishes it, initially `vo.map.localise_only`) no keyframes are
/// published; frames are lost until the camera is found in the map, and again if tracking resumed at a place that is
/// not in the map.
class VoNode {
 public:
  VoNode(bus::Process& process, const VoOptions& options);
  ~VoNode();
  VoNode(const VoNode&) = delete;
  VoNode& operator=(const VoNode&) = delete;

 private:
  using Frame = bus::FrameSubscriber::Frame;
  /// Conditions for which the next frame waits.
  enum class Wait {
    kNothing,
    kCamera,          ///< until a usable camera of the publisher of the frames is received
    kFirstMap,        ///< localisation only: until a map is received
    kMap,             ///< lockstep: until the map has the keyframe before the newest, or mapping_process is gone
    kRelocalisation,  ///< lockstep: until the open request has its result, or loop_process is gone
    kOlderFrames,     ///< after a restart: until the player has gone back, at most 15 s
  };

  void OnCamera(const RigCalibration& rig);
  void OnFrame(const Frame& frame);
  void OnStream(const stream_t& message);
  void OnStatus(const status_t& message);
  void OnMap();
  void AdoptMap(bool landmarks);
  bool IsAnchored() const;
  void AwaitAnchor(const Keyframe& first);
  bool IsLocaliseOnly() const;
  void FollowOrders();
  void OnRelocalisation(const relocalisation_t& message);
  void SubscribeToMap();
  bool AwaitsOthers(const Frame& frame);
  void GiveUpWaits();

  Wait WaitsFor() const;
  void ProcessWaiting();
  void EndWaits();
  bool IsRepeated(const Frame& frame) const;
  void AnswerAgain(const Frame& frame);
  void BeginSession();
  void BeginSessionHere();
  void NameSession();
  bool IsTooEarly(const Frame& frame) const;

  void Track(const Frame& frame);
  StereoFeatures SeeFeatures(const StereoImages& images, StageTimer& timer);
  StereoFeatures NoFeatures(const StereoImages& images);
  TrackingState StateOf(const OdometryResult& result) const;
  void NoteAnchor(const Frame& frame, const OdometryResult& result);
  bool NeedsRelocalisation(const Frame& frame, const OdometryResult& result) const;
  void RequestRelocalisation(const Frame& frame, const OdometryResult& result);
  bool IsIndependentOfTracker(const Map& map, KeyframeId keyframe_id) const;
  void AwaitMap(int64_t keyframe_id);

  void SetHeader(const Frame& frame, header_t& header) const;
  void PublishPose(const Frame& frame, const OdometryResult& result, const std::vector<StageTime>& stages);
  void PublishTracks(const Frame& frame, const OdometryResult& result);
  void MakeKeyframe(const Frame& frame, const OdometryResult& result, bool requests);
  void PublishKeyframe();

  void Restore();
  void Restore(const TrackerState& state);
  void KeepState(const Keyframe& keyframe);
  bool MissesFramesBefore(const Frame& frame) const;
  void RepeatResendRequest();

  void FinishIfDone();

  bus::Process& process_;
  VoOptions options_;
  std::string settings_;  ///< the options as text
  TrackerReport report_;
  TrackerSession session_;
  std::optional<RigCalibration> rig_;
  std::optional<StereoFrontEnd> front_end_;
  std::optional<Odometry> odometry_;
  std::vector<Frame> waiting_;
  bus::KeyframePublisher keyframes_;
  /// The newest keyframe, in lockstep held until the map of the previous one is adopted.
  std::optional<Keyframe> held_keyframe_;
  RelocalisationClient relocalisation_;
  FrameInputs inputs_;
  TrackerCheckpoint checkpoint_;
  /// Whether the state of a crashed tracker was restored, and no frame has arrived since.
  bool restored_ = false;
  ResendRequest resend_;
  int64_t announced_frames_ = -1;
  std::optional<MapLink> map_;
  // Last, because their handlers use all of the above.
  bus::CameraSubscriber camera_;
  bus::FrameSubscriber frames_;
};

bus::ProcessSpec VoSpec();

}  // namespace plslam::vo
