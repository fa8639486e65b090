#include <algorithm>
#include <utility>

#include "core/bus/messages/loop_channel.h"
#include "core/process/worker.h"
#include "plslam/relocalisation_t.hpp"
#include "vo_process/node/vo_node.h"

// How a camera that does not know where it is finds out: loop_process is asked.

namespace plslam {
namespace {

// Fewer features are not worth asking about; and how long a question may remain without an answer in a live stream.
constexpr size_t kLeastToAsk = 20;
constexpr double kAskAgain_s = 2.0;
// How long a camera that is adrift asks while the map grows: somebody else may find out, a loop is closed.
constexpr uint64_t kAdrift_ns = 3'000'000'000;

bool IsOfMap(const FeatureTrack& track) { return track.map_id >= 0; }

// Landmarks of the map among those tracked, points + 2 x lines.
int64_t TrackedOfMap(const OdometryResult& result) {
  return std::count_if(result.point_tracks.begin(), result.point_tracks.end(), IsOfMap) +
         2 * std::count_if(result.line_tracks.begin(), result.line_tracks.end(), IsOfMap);
}

}  // namespace

/// What users are told: in a map that stays as it is, a place that is not known in it is none.
TrackingState VoNode::StateOf(const OdometryResult& result) const {
  const bool placed = !options_.map.localise_only || (odometry_->is_in_map() && !odometry_->is_adrift());
  return placed ? result.state : TrackingState::kLost;
}

/// Lost; or, in a map that grows, adrift for not too long; or, in one that stays, after a keyframe that saw too little of it to be
/// held in place. A tracker that goes on from the state as of a keyframe asks what this one asked: after it, not at it.
bool VoNode::NeedsToAsk(const Frame& frame, const OdometryResult& result) {
  const bool lost = StateOf(result) == TrackingState::kLost;
  // An answer on its way is about where it was before; adrift, that is what counts, but not across a jump.
  if (result.jumped || (result.state == TrackingState::kRecovered && !odometry_->is_adrift())) question_.reset();
  if (lost || !odometry_->is_adrift()) adrift_since_ns_ = frame.images.t_ns;
  if (lost) return true;
  if (options_.map.localise_only) return follows_keyframe_ && TrackedOfMap(result) < options_.tracking.weak_inliers;
  // Unsigned: times may be any.
  const uint64_t adrift_ns = static_cast<uint64_t>(frame.images.t_ns) - static_cast<uint64_t>(adrift_since_ns_);
  return odometry_->is_adrift() && !result.keyframe && adrift_ns < kAdrift_ns;
}

/// Adrift, the camera is always where it made its own keyframes since.
bool VoNode::IsNews(const Map& map, int64_t keyframe_id) const {
  const MapKeyframe* keyframe = map.FindKeyframe(keyframe_id);
  return keyframe == nullptr || keyframe->session != session_ || keyframe->t_ns <= adrift_since_ns_;
}

/// Live, a question that has not been answered for a while is asked anew.
void VoNode::AskWhereIAm(const Frame& frame, const OdometryResult& result) {
  if (!map_ || !options_.relocalisation.enabled || map_->replica().map().keyframes().empty()) return;
  const double now_s = bus::NowS();
  if (question_ && !frame.lockstep && now_s - question_->asked_s < kAskAgain_s) return;
  if (result.features.points.size() + result.features.lines.size() < kLeastToAsk) return;
  Keyframe asked;
  asked.session = session_;
  asked.t_ns = frame.images.t_ns;
  asked.frame_id = frame.images.frame_id;
  asked.previous_keyframe_id = options_.map.localise_only ? -1 : last_keyframe_id_;
  asked.keyframe_id = asked.previous_keyframe_id + 1;
  asked.lockstep = frame.lockstep;
  asked.features = result.features;
  asked.point_landmark_ids.assign(asked.features.points.size(), -1);
  asked.line_landmark_ids.assign(asked.features.lines.size(), -1);
  questions_.Publish(asked);
  question_ = RelocalisationQuestion{std::move(asked), result.T_odom_c, now_s};
  Count("relocalisation.asked", 1);
  if (frame.lockstep) answer_wait_.Begin(frame.images.frame_id, now_s);
}

/// A loop_process that was not heard before may have been started in the place of one that died with the question.
void VoNode::OnLoopProcess(int64_t source) {
  answer_wait_.OnSignOfLife(bus::NowS());
  const bool is_new = loop_sources_.insert(source).second;
  if (is_new && loop_sources_.size() > 1 && question_ && answer_wait_.awaited()) questions_.Publish(question_->sent);
}

void VoNode::OnRelocalisation(const relocalisation_t& message) {
  const std::optional<Relocalisation> answer = bus::FromMessage(message);
  const bool ours =
      answer && question_ && answer->session == session_ && answer->frame_id == question_->sent.frame_id && odometry_;
  if (!ours) return;
  const SE3 T_w_odom = answer->T_w_c * question_->T_odom_c.Inverse();
  const Map& map = map_->replica().map();
  if (answer->found && IsNews(map, answer->keyframe_id) &&
      odometry_->Relocalise(map, answer->keyframe_id, T_w_odom)) {
    Count("relocalisation.found", 1);
  }
  question_.reset();
  answer_wait_.End();
  GoOn();
}

}  // namespace plslam
