#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/bus/frame_channel.h"
#include "core/bus/keyframe_channel.h"
#include "core/bus/map_channel.h"
#include "core/bus/partner_wait.h"
#include "core/bus/process.h"
#include "plslam/pose_t.hpp"

#include "vo_process/odometry.h"
#include "vo_process/options.h"
#include "vo_process/relocalisation_question.h"
#include "vo_process/stereo_front_end.h"

namespace plslam {
class camera_t;
class header_t;
class relocalisation_t;
class status_t;
class stream_t;
struct TrackerState;

/// vo_process on the bus: camera and frames in; poses, tracks and keyframes out.
///
/// Frames wait for the camera. Another camera, or time that goes back (another stream), begins a new session, since
/// nothing of the old one holds there. A frame that does not fit the camera is answered as one without features, and so is
/// one of the same stream that is less than a second too early (a clock that was put right).
///
/// The map, where there is one, takes effect at once in a live stream. In lockstep, that of keyframe k takes effect when
/// keyframe k + 1 has been made, and is awaited there: the result does not hang on who is faster. So is the answer of
/// loop_process to the question where a lost camera is, before the next frame.
///
/// With a `state_file` the state is kept at each keyframe, before that goes out: a tracker that is started in the
/// place of one that was killed goes on as the same session, with the frame after its newest keyframe. In lockstep the
/// player sends these again, and the result is the same, bit for bit.
///
/// In a map that stays as it is (`vo.map.localise_only`) no keyframes are sent; a frame counts as lost until the camera has
/// been found in the map, and again where it has gone on at a place that nobody knows.
class VoNode {
 public:
  VoNode(bus::Process& process, const VoOptions& options);
  ~VoNode();
  VoNode(const VoNode&) = delete;
  VoNode& operator=(const VoNode&) = delete;

 private:
  using Frame = bus::FrameSubscriber::Frame;

  void OnCamera(const camera_t& message);
  void OnFrame(const Frame& frame);
  void OnStream(const stream_t& message);
  void OnStatus(const status_t& message);
  void OnMap();
  void OnRelocalisation(const relocalisation_t& message);
  void OnLoopProcess(int64_t source);
  bool IsWaiting() const;
  const pose_t* FindRecent(const Frame& frame) const;
  bool IsRepeated(const Frame& frame) const;
  void AnswerAgain(const Frame& frame);
  void AwaitMap(int64_t keyframe_id);
  bool AdoptMap(int64_t oldest_keyframe_id);
  TrackingState StateOf(const OdometryResult& result) const;
  bool NeedsToAsk(const Frame& frame, const OdometryResult& result);
  bool IsNews(const Map& map, int64_t keyframe_id) const;
  void AskWhereIAm(const Frame& frame, const OdometryResult& result);
  void Listen();
  void GoOn();
  void BeginSession();
  void EndWaits();
  bool IsTooEarly(const Frame& frame) const;
  void Track(const Frame& frame);
  StereoFeatures SeeFeatures(const StereoImages& images, StageTimer& timer);
  StereoFeatures NoFeatures(const StereoImages& images);
  void SetHeader(const Frame& frame, header_t& header) const;
  void PublishPose(const Frame& frame, const OdometryResult& result, const std::vector<StageTime>& stages);
  void PublishTracks(const Frame& frame, const OdometryResult& result);
  void MakeKeyframe(const Frame& frame, const OdometryResult& result, bool asks);
  void PublishKeyframe();
  void Restore();
  void GoOnWith(const TrackerState& state);
  void KeepState(const Keyframe& keyframe);
  void DropState() const;
  bool LacksFramesBefore(const Frame& frame) const;
  void AskForFrames();
  void AskAgainForFrames();
  void Count(const std::string& name, double increment);
  void FinishIfDone();
  void SetState(const std::string& state);
  void TellOfRows();
  void LookAt(const StereoImages& images, const StereoFeatures& features);
  void TellOfWarnings();

  bus::Process& process_;
  VoOptions options_;
  std::string settings_;  ///< the same as text
  int64_t session_ = 0;
  std::vector<uint8_t> camera_bytes_;
  std::optional<RigCalibration> rig_;
  std::optional<StereoFrontEnd> front_end_;
  std::optional<Odometry> odometry_;
  std::vector<Frame> waiting_;
  /// The latest of the session.
  int64_t last_t_ns_ = 0;
  int64_t last_frame_id_ = -1;
  int64_t last_source_ = 0;
  /// Of the newest frames of the session.
  std::deque<pose_t> recent_;
  int64_t announced_frames_ = -1;
  std::map<std::string, double> counts_;
  std::string state_;
  std::string warnings_;  ///< what the state is told with
  bus::KeyframePublisher keyframes_;
  bus::PartnerWait map_wait_;
  /// Of loop_process, to the question where the camera is.
  bus::PartnerWait answer_wait_;
  bus::KeyframePublisher questions_;
  std::optional<RelocalisationQuestion> question_;
  /// All that were heard.
  std::set<int64_t> loop_sources_;
  /// Until then the camera was not adrift, or lost.
  int64_t adrift_since_ns_ = 0;
  /// The frame before became a keyframe, and has not asked.
  bool follows_keyframe_ = false;
  bool lockstep_ = false;
  /// The newest keyframe of the session in the map; other robots' may be in it too.
  int64_t map_keyframe_id_ = -1;
  int64_t adopted_keyframe_id_ = -1;
  int64_t last_keyframe_id_ = -1;
  /// Waits, in lockstep, for the map of the one before.
  std::optional<Keyframe> held_keyframe_;
  /// It goes on with the state of another, and no frame has come yet.
  bool restored_ = false;
  bool state_failed_ = false;
  bool was_too_early_ = false;
  bool told_of_rows_ = false;
  /// Since when frames are wanted again, and the publisher of frames that was heard of last.
  std::optional<double> frames_asked_s_;
  int64_t player_ = 0;
  std::unique_ptr<bus::MapSubscriber> map_;
  // Last: its handler needs all of the above.
  bus::FrameSubscriber frames_;
};

bus::ProcessSpec VoSpec();

}  // namespace plslam
