#include "vo_process/vo_node.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "core/bus/convert.h"
#include "core/bus/worker.h"
#include "core/run/run_warnings.h"
#include "plslam/camera_t.hpp"
#include "plslam/header_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "vo_process/keyframe_value.h"
#include "vo_process/see_pair.h"
#include "vo_process/vo_messages.h"

namespace plslam {
namespace {

// Frames kept while no camera or map has come; later ones are answered when it has, earlier ones are given up.
constexpr size_t kMaxWaitingFrames = 8;
constexpr size_t kRecentFrames = 16;
// Time that goes back by less is of the same stream.
constexpr uint64_t kClockStep_ns = 1'000'000'000;

/// Darker than the noise of a sensor that sees something: of every 8th row, 8 of 255 on average.
bool IsNearlyBlack(const cv::Mat& image) {
  constexpr int kEveryRow = 8;
  constexpr double kDark = 8.0;
  double sum = 0.0;
  int rows = 0;
  for (int row = 0; row < image.rows; row += kEveryRow, ++rows) sum += cv::mean(image.row(row))[0];
  return rows > 0 && sum < kDark * rows;
}

}  // namespace

VoNode::VoNode(bus::Process& process, const VoOptions& options)
    : process_(process),
      options_(options),
      settings_(ToYaml("vo", options_)),
      session_(process.bus().source()),
      keyframes_(process.bus()),
      map_wait_(options.map.wait_s),
      answer_wait_(options.relocalisation.wait_s),
      questions_(process.bus(), bus::kWhereAmI),
      frames_(process.bus(), bus::FrameSubscriber::Mode::kReliable, [this](const Frame& f) { OnFrame(f); }) {
  // Left and right are the two threads; more inside OpenCV would only get in their way.
  cv::setNumThreads(1);
  process_.bus().Subscribe<camera_t>(bus::kCamera, [this](const camera_t& m) { OnCamera(m); });
  process_.bus().Subscribe<stream_t>(bus::kStream, [this](const stream_t& m) { OnStream(m); });
  process_.bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
  if (options_.map.enabled) Listen();
  process_.SetConfiguration(settings_);
  Restore();
}

VoNode::~VoNode() { DropState(); }

void VoNode::OnCamera(const camera_t& message) {
  std::vector<uint8_t> bytes = bus::RigBytes(message);
  if (bytes == camera_bytes_) return;
  camera_bytes_ = std::move(bytes);
  const std::optional<RigCalibration> rig = bus::FromMessage(message);
  if (!rig) {
    spdlog::error("the camera '{}' has values that cannot be: it is not used", message.rig_name);
    Count("cameras.rejected", 1);
    return;
  }
  try {
    front_end_.emplace(*rig, options_);
  } catch (const std::exception& error) {
    front_end_.reset();
    process_.SetState("failed", error.what());
    throw;
  }
  if (rig_) {
    spdlog::info("another camera '{}': a new session begins", rig->name);
    // What the old one waits for is not for this one, nor are its frames.
    EndWaits();
    waiting_.clear();
  }
  rig_ = *rig;
  told_of_rows_ = false;
  odometry_.reset();
  GoOn();
}

void VoNode::OnFrame(const Frame& frame) {
  if (IsRepeated(frame)) return AnswerAgain(frame);
  player_ = frame.source;
  if (LacksFramesBefore(frame)) {
    if (!frames_asked_s_) AskForFrames();
  } else if (frames_asked_s_) {
    // Those that have come too early come again.
    frames_asked_s_.reset();
    waiting_.clear();
  }
  if (front_end_ && !IsWaiting()) return Track(frame);
  if (waiting_.size() == kMaxWaitingFrames) {
    waiting_.erase(waiting_.begin());
    Count(front_end_ ? "frames.dropped_waiting" : "frames.without_camera", 1);
  }
  waiting_.push_back(frame);
}

bool VoNode::IsRepeated(const Frame& frame) const {
  if (frame.source == last_source_) return frame.images.frame_id <= last_frame_id_;
  // A player that was started in the place of another may not have heard of the last poses.
  return frame.images.frame_id > 0 && FindRecent(frame) != nullptr;
}

const pose_t* VoNode::FindRecent(const Frame& frame) const {
  const auto found = std::find_if(recent_.begin(), recent_.end(), [&frame](const pose_t& pose) {
    return pose.frame_id == frame.images.frame_id && pose.header.t_ns == frame.images.t_ns;
  });
  return found == recent_.end() ? nullptr : &*found;
}

/// A player that sends a frame again has not heard of its pose, or has gone back for a tracker that needed no more.
void VoNode::AnswerAgain(const Frame& frame) {
  Count("frames.repeated", 1);
  const pose_t* pose = frame.lockstep ? FindRecent(frame) : nullptr;
  if (pose != nullptr) process_.bus().Publish(bus::kPose, pose_t(*pose));
}

bool VoNode::IsWaiting() const {
  const bool lacks_map = options_.map.localise_only && map_ && map_->replica().version() == 0;
  return lacks_map || map_wait_.awaited() || answer_wait_.awaited() || frames_asked_s_;
}

void VoNode::GoOn() {
  if (!map_wait_.awaited()) PublishKeyframe();
  while (front_end_ && !IsWaiting() && !waiting_.empty()) {
    const Frame frame = std::move(waiting_.front());
    waiting_.erase(waiting_.begin());
    if (!IsRepeated(frame)) Track(frame);
  }
}

void VoNode::OnStatus(const status_t& message) {
  if (message.process == "player") player_ = message.header.source;
  if (message.process == "mapping") map_wait_.OnSignOfLife(bus::NowS());
  if (message.process == "loop") OnLoopProcess(message.header.source);
}

void VoNode::OnStream(const stream_t& message) {
  announced_frames_ = message.event == "end" ? message.n_frames : -1;
  FinishIfDone();
}

void VoNode::EndWaits() {
  map_wait_.End();
  answer_wait_.End();
  question_.reset();
}

void VoNode::BeginSession() {
  EndWaits();
  PublishKeyframe();
  // That of a tracker whose state this one has taken over is not the next of ours.
  if (last_t_ns_ != 0) session_ = std::max(session_ + 1, process_.bus().source());
  follows_keyframe_ = false;
  map_keyframe_id_ = -1;
  adopted_keyframe_id_ = -1;
  last_keyframe_id_ = -1;
  recent_.clear();
  odometry_.emplace(front_end_->camera(), options_);
}

/// Of the stream of the frame before, and a little before it.
bool VoNode::IsTooEarly(const Frame& frame) const {
  const bool goes_on = odometry_ && frame.source == last_source_ && frame.images.frame_id > last_frame_id_;
  // Unsigned: times may be any.
  const uint64_t back_ns = static_cast<uint64_t>(last_t_ns_) - static_cast<uint64_t>(frame.images.t_ns);
  return goes_on && frame.images.t_ns < last_t_ns_ && back_ns < kClockStep_ns;
}

void VoNode::Track(const Frame& frame) {
  const bool too_early = IsTooEarly(frame);
  if (!odometry_ || (frame.images.t_ns < last_t_ns_ && !too_early)) BeginSession();
  lockstep_ = frame.lockstep;
  if (!too_early) last_t_ns_ = frame.images.t_ns;
  StageTimer timer(bus::NowMs);
  const OdometryResult result = timer.Time("total", [&] {
    StereoFeatures features = too_early ? NoFeatures(frame.images) : SeeFeatures(frame.images, timer);
    return timer.Time("track", [&] { return odometry_->Track(last_t_ns_, std::move(features), front_end_->left()); });
  });
  // The pose first: somebody waits for it.
  PublishPose(frame, result, timer.stages());
  PublishTracks(frame, result);
  last_frame_id_ = frame.images.frame_id;
  last_source_ = frame.source;
  restored_ = false;
  const bool asks = NeedsToAsk(frame, result);
  if (result.keyframe) MakeKeyframe(frame, result, asks);
  if (asks) AskWhereIAm(frame, result);
  follows_keyframe_ = result.keyframe && !asks;
  SetState("running");
  Count("frames", 1);
  Count("frames.skipped", frame.skipped);
  if (StateOf(result) == TrackingState::kLost) Count("frames.lost", 1);
  if (result.keyframe) Count("keyframes", 1);
  LookAt(frame.images, result.features);
  TellOfRows();
  TellOfWarnings();
  FinishIfDone();
}

/// Once for each camera.
void VoNode::TellOfRows() {
  if (told_of_rows_) return;
  const RowField rows = odometry_->rows();
  if (rows.is_zero()) return;
  told_of_rows_ = true;
  const StereoCamera& camera = front_end_->camera();
  double most_px = 0.0;
  for (const double u_px : {0.0, camera.width_px - 1.0}) {
    for (const double v_px : {0.0, camera.height_px - 1.0}) {
      most_px = std::max(most_px, std::abs(rows.Offset_px({u_px, v_px})));
    }
  }
  Count(std::string(kCornerRows), most_px);
  spdlog::info(
      "in the corners, rows of the right image differ from those of the left by up to {:.1f} px: they are followed, "
      "but the calibration could be better",
      most_px);
}

/// Counts what tells of bad images and of a bad calibration.
void VoNode::LookAt(const StereoImages& images, const StereoFeatures& features) {
  if (IsNearlyBlack(images.left)) Count(std::string(kFramesDark), 1);
  if (rig_->kind == RigCalibration::Kind::kRgbd) return;
  // Flat lines have no depth even where all is well.
  const auto matched =
      std::count_if(features.points.begin(), features.points.end(), [](const auto& p) { return p.HasDepth(); });
  Count(std::string(kPointsSeen), static_cast<double>(features.points.size()));
  Count(std::string(kPointsMatched), static_cast<double>(matched));
}

/// With the state, for who looks at the run while it goes on.
void VoNode::TellOfWarnings() {
  static constexpr int kEvery = 20;
  if (static_cast<int64_t>(counts_["frames"]) % kEvery != 0) return;
  RunFindings findings;
  findings.points_seen = counts_[std::string(kPointsSeen)];
  findings.points_matched = counts_[std::string(kPointsMatched)];
  findings.corner_rows_px = counts_[std::string(kCornerRows)];
  std::string warnings;
  for (const RunWarning& warning : WarningsOf(findings)) {
    warnings += (warnings.empty() ? "" : "; ") + warning.sentence;
  }
  if (warnings == warnings_) return;
  warnings_ = std::move(warnings);
  process_.SetState(state_, warnings_);
}

StereoFeatures VoNode::SeeFeatures(const StereoImages& images, StageTimer& timer) {
  try {
    return SeePair(*front_end_, *odometry_, images, timer);
  } catch (const std::exception& error) {
    spdlog::warn("frame {}: {}", images.frame_id, error.what());
    Count("frames.bad", 1);
    return {};
  }
}

/// Of a frame whose time cannot be.
StereoFeatures VoNode::NoFeatures(const StereoImages& images) {
  if (!std::exchange(was_too_early_, true)) {
    spdlog::warn(
        "frame {} is of an earlier time than the one before it, by less than a second: such frames are not used",
        images.frame_id);
  }
  Count("frames.bad", 1);
  return {};
}

void VoNode::SetHeader(const Frame& frame, header_t& header) const {
  header.session = session_;
  header.t_ns = frame.images.t_ns;
}

void VoNode::PublishPose(const Frame& frame, const OdometryResult& result, const std::vector<StageTime>& stages) {
  pose_t message = ToPoseMessage(result, odometry_->T_w_odom(), stages);
  SetHeader(frame, message.header);
  message.frame_id = frame.images.frame_id;
  message.n_skipped_frames = frame.skipped;
  if (options_.map.localise_only) {
    message.keyframe_id = -1;
    message.state = static_cast<int8_t>(StateOf(result));
    if (StateOf(result) != result.state) {
      for (int i = 0; i < 6; ++i) message.covariance[7 * i] += UnknownMotion()(i, i);
    }
  }
  process_.bus().Publish(bus::kPose, message);
  recent_.push_back(std::move(message));
  if (recent_.size() > kRecentFrames) recent_.pop_front();
}

void VoNode::PublishTracks(const Frame& frame, const OdometryResult& result) {
  tracks_t message = ToTracksMessage(result);
  SetHeader(frame, message.header);
  message.frame_id = frame.images.frame_id;
  process_.bus().Publish(bus::kTracks, message);
}

/// Where the map stays as it is, a keyframe is where the tracker looks around in it anew.
void VoNode::MakeKeyframe(const Frame& frame, const OdometryResult& result, bool asks) {
  last_keyframe_id_ = result.keyframe->id;
  if (options_.map.localise_only) {
    if (map_) odometry_->AdoptAround(map_->replica().map());
    if (StateOf(result) == TrackingState::kLost) return DropState();
    Keyframe none;
    none.keyframe_id = -1;
    // No state tells of a question: who asks here goes on, if killed, from an older keyframe.
    if (!asks) KeepState(none);
    return;
  }
  Keyframe keyframe = ToKeyframe(result);
  keyframe.session = session_;
  keyframe.t_ns = frame.images.t_ns;
  keyframe.frame_id = frame.images.frame_id;
  keyframe.lockstep = frame.lockstep;
  AwaitMap(keyframe.keyframe_id);
  held_keyframe_ = std::move(keyframe);
  if (!map_wait_.awaited()) PublishKeyframe();
}

/// Once the state is kept, or another keyframe of this number could be made of an older one; and in lockstep once the map of
/// the one before has been taken over: whoever goes on from the state finds the map as this one left it.
void VoNode::PublishKeyframe() {
  if (!held_keyframe_) return;
  const Keyframe keyframe = *std::exchange(held_keyframe_, std::nullopt);
  KeepState(keyframe);
  keyframes_.Publish(keyframe);
}

void VoNode::Count(const std::string& name, double increment) {
  double& count = counts_[name];
  count += increment;
  process_.SetCounter(name, count);
}

void VoNode::FinishIfDone() {
  if (announced_frames_ >= 0 && last_frame_id_ + 1 >= announced_frames_) SetState("finished");
}

void VoNode::SetState(const std::string& state) {
  if (state == std::exchange(state_, state)) return;
  process_.SetState(state, warnings_);
}

bus::ProcessSpec VoSpec() {
  bus::ProcessSpec spec;
  spec.name = "vo";
  spec.description = "Stereo odometry with points and lines: frames in, poses and keyframes out.";
  spec.examples =
      "  vo_process\n"
      "  vo_process --config config/euroc.yaml --set vo.features.features=points\n"
      "  vo_process --url udpm://239.255.76.67:7667?ttl=1 --prefix front/";
  spec.make_node = [](bus::Process& process, const Config& config) -> std::shared_ptr<void> {
    VoOptions options;
    config.Read("vo", options);
    return std::make_shared<VoNode>(process, options);
  };
  return spec;
}

}  // namespace plslam
