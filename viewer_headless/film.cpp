// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/film.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "core/errors/log.h"
#include "core/map/vertical.h"

namespace plslam::viewer {

void FilmPath::Add(const FramePose& pose) {
  FrameRecord frame;
  frame.state = pose.state;
  frame.keyframe_id = pose.keyframe_id;
  if (HasPose(frame)) {
    const Eigen::Vector3d& p_odom = pose.T_odom_c.translation();
    steps_.push_back({pose.frame_id, pose.session, p_odom, pose.T_w_odom * p_odom});
  } else if (pose.state == TrackingState::kLost) {
    lost_frames_.insert(pose.frame_id);
  }
}

std::vector<Eigen::Vector3d> FilmPath::In(const Map& map) const {
  const std::map<SessionId, FrameCorrections> sessions = CorrectionsBySession(map);
  std::vector<Eigen::Vector3d> path;
  path.reserve(steps_.size());
  for (const Step& step : steps_) {
    const auto session = sessions.find(step.session);
    const SE3* T_w_odom = session == sessions.end() ? nullptr : CorrectionOf(step, session->second);
    path.push_back(T_w_odom == nullptr ? step.p_w : *T_w_odom * step.p_odom);
  }
  return path;
}

const SE3* FilmPath::CorrectionOf(const Step& step, const FrameCorrections& corrections) const {
  const auto after = corrections.upper_bound(step.frame_id);
  if (after != corrections.begin()) {
    const auto before = std::prev(after);
    if (NextLost(before->first) >= step.frame_id) return &before->second;
  }
  const bool reached = after != corrections.end() && NextLost(step.frame_id) >= after->first;
  return reached ? &after->second : nullptr;
}

FrameId FilmPath::NextLost(FrameId from) const {
  const auto lost = lost_frames_.lower_bound(from);
  return lost == lost_frames_.end() ? FrameId(std::numeric_limits<int64_t>::max()) : *lost;
}

namespace {

constexpr double kLongestStill = 50.0;
constexpr double kSlowest_hz = 1.0;
constexpr double kFastest_hz = 120.0;

TopViewScene SceneOf(const Map& map, const std::vector<Eigen::Vector3d>& path_w,
                     const Eigen::Quaterniond& q_level_w) {
  const Eigen::Matrix3d R = q_level_w.toRotationMatrix();
  TopViewScene scene;
  scene.points.reserve(map.points().size());
  for (const auto& [id, point] : map.points()) scene.points.emplace_back(R * point.p_w);
  for (const auto& [id, line] : map.lines()) scene.segments.emplace_back(R * line.segment_w.p, R * line.segment_w.q);
  scene.path.reserve(path_w.size());
  for (const Eigen::Vector3d& p_w : path_w) scene.path.emplace_back(R * p_w);
  return scene;
}

}  // namespace

void Film::Finish() {
  if (failure_) throw std::runtime_error(*failure_);
  // The first picture is still waiting for a second one: the film has only one picture.
  if (first_) {
    Open(PictureRate_hz(0, 0, 0), first_->picture.size());
    video_->Add(first_->picture);
  }
  if (!video_) throw std::runtime_error(path_ + ": no film: no pictures were received");
  video_->Close();
  LogInfo("film of the run: {} ({} pictures)", video_->path(), video_->pictures());
}

void Film::Open(double rate_hz, const cv::Size& size) {
  video_ = std::make_unique<RunVideo>(path_, std::move(program_), rate_hz, size);
  if (!video_->why_folder().empty()) {
    note_ = fmt::format("{}; numbered pictures are written to {}", video_->why_folder(), video_->path());
  }
}

void Film::Add(const FramePose& pose, const cv::Mat& overlay, const Map& map) {
  if (failure_) return;
  positions_.Add(pose);
  // A few new lines do not turn the map.
  const bool more_keyframes = map.keyframes().size() != levelled_keyframes_;
  if (more_keyframes) q_level_w_ = LevelRotation(VerticalOf(map).up_w);
  levelled_keyframes_ = map.keyframes().size();
  const TopViewScene scene = SceneOf(map, positions_.In(map), q_level_w_);
  window_.Include(scene.path);
  if (more_keyframes) window_.IncludeMiddle(scene.points);
  const cv::Mat view = DrawTopView(scene, window_, MapSizeBeside(overlay.size()));
  try {
    Write(pose, Join(overlay, view));
  } catch (const std::runtime_error& e) {
    LogError("frame {}: {}", pose.frame_id, e.what());
    failure_ = e.what();
    first_.reset();
    video_.reset();
  }
}

void Film::Begin(const Waiting& first, double rate_hz) {
  rate_hz_ = rate_hz;
  Open(rate_hz_, first.picture.size());
  video_->Add(first.picture);
  began_ns_ = t_ns_ = first.pose.t_ns;
  shown_ = 1.0;
}

void Film::Write(const FramePose& pose, const cv::Mat& picture) {
  if (!video_ && !first_) {
    first_ = Waiting{pose, picture};
    // If the camera rate is unknown, the time of the second picture determines it.
    if (camera_rate_hz_ <= 0.0) return;
    Begin(*std::exchange(first_, std::nullopt), std::clamp(camera_rate_hz_, kSlowest_hz, kFastest_hz));
    return;
  }
  if (first_) Begin(*first_, PictureRate_hz(first_->pose.t_ns, pose.t_ns, 1));
  first_.reset();
  if (pose.t_ns < t_ns_) {
    began_ns_ = pose.t_ns;
    shown_ = 0.0;
  }
  t_ns_ = pose.t_ns;
  // Each picture appears at its time, so that the film lasts as long as the run: it is repeated for missing ones before
  // it, and skipped if the next one falls into the same slot.
  const double due = std::round(1e-9 * static_cast<double>(t_ns_ - began_ns_) * rate_hz_) + 1.0;
  const double pictures = std::clamp(due - shown_, 0.0, kLongestStill);
  for (int i = 0; i < static_cast<int>(pictures); ++i) video_->Add(picture);
  shown_ = due;
}

}  // namespace plslam::viewer
