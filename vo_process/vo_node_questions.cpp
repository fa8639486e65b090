#include "core/bus/loop_channel.h"
#include "core/bus/worker.h"
#include "plslam/relocalisation_t.hpp"
#include "vo_process/vo_node.h"

// How a camera that is lost finds out where it is: loop_process is asked.

namespace plslam {
namespace {

// Fewer features are not worth asking about; and how long a question may remain without an answer in a live stream.
constexpr size_t kLeastToAsk = 20;
constexpr double kAskAgain_s = 2.0;
constexpr int kMaxAsked = 60;

}  // namespace

/// Live, a question that has not been answered for a while is asked anew.
void VoNode::AskWhereIAm(const Frame& frame, const OdometryResult& result) {
  const bool in_place =
      result.state != TrackingState::kLost && (odometry_->is_in_map() || !options_.map.localise_only);
  if (in_place) question_.reset();
  // Adrift, somebody else may find out: a loop is closed.
  n_asked_ = in_place ? 0 : n_asked_ + 1;
  if (!map_ || !options_.relocalisation.enabled || in_place || map_->replica().map().keyframes().empty()) return;
  if (odometry_->is_adrift() && n_asked_ > kMaxAsked) return;
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
  question_ = RelocalisationQuestion{frame.images.frame_id, result.T_odom_c, now_s};
  questions_.Publish(asked);
  Count("relocalisation.asked", 1);
  if (frame.lockstep) answer_wait_.Begin(frame.images.frame_id, now_s);
}

void VoNode::OnRelocalisation(const relocalisation_t& message) {
  const std::optional<Relocalisation> answer = bus::FromMessage(message);
  const bool ours =
      answer && question_ && answer->session == session_ && answer->frame_id == question_->frame_id && odometry_;
  if (!ours) return;
  const SE3 T_w_odom = answer->T_w_c * question_->T_odom_c.Inverse();
  if (answer->found && odometry_->Relocalise(map_->replica().map(), answer->keyframe_id, T_w_odom)) {
    Count("relocalisation.found", 1);
  }
  question_.reset();
  answer_wait_.End();
  GoOn();
}

}  // namespace plslam
