#include "viewer_headless/film.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>

namespace plslam {
namespace {

constexpr double kLongestStill = 50.0;

TopViewScene SceneOf(const Map& map, const std::vector<Eigen::Vector3d>& path) {
  TopViewScene scene;
  scene.points.reserve(map.points().size());
  for (const auto& [id, point] : map.points()) scene.points.push_back(point.p_w);
  for (const auto& [id, line] : map.lines()) scene.segments.emplace_back(line.segment_w.p, line.segment_w.q);
  scene.path = path;
  return scene;
}

}  // namespace

Film::~Film() {
  try {
    if (first_) {
      Open(PictureRate_hz(0, 0, 0), first_->picture.size());
      video_->Add(first_->picture);
    }
    if (!video_) return;
    video_->Close();
    spdlog::info("film of the run: {} ({} pictures)", video_->path(), video_->pictures());
  } catch (const std::exception& e) {
    spdlog::error("{}", e.what());
  }
}

void Film::Open(double rate_hz, const cv::Size& size) {
  video_ = std::make_unique<RunVideo>(path_, std::move(program_), rate_hz, size);
  if (!video_->why_folder().empty()) {
    spdlog::warn("{}; numbered pictures go to {}", video_->why_folder(), video_->path());
  }
}

void Film::Add(const FramePose& pose, const cv::Mat& overlay, const Map& map) {
  if (failed_) return;
  positions_.push_back((pose.T_w_odom * pose.T_odom_c).translation());
  window_.Include({positions_.back()});
  const cv::Mat view = DrawTopView(SceneOf(map, positions_), window_, MapSizeBeside(overlay.size()));
  try {
    Write(pose, Join(overlay, view));
  } catch (const std::runtime_error& e) {
    spdlog::error("frame {}: {}", pose.frame_id, e.what());
    failed_ = true;
    first_.reset();
    video_.reset();
  }
}

void Film::Write(const FramePose& pose, const cv::Mat& picture) {
  if (!video_ && !first_) {
    // The second one tells how many there are in a second.
    first_ = Waiting{pose, picture};
    return;
  }
  if (first_) {
    rate_hz_ = PictureRate_hz(first_->pose.t_ns, pose.t_ns, 1);
    Open(rate_hz_, first_->picture.size());
    video_->Add(first_->picture);
    t_ns_ = first_->pose.t_ns;
    first_.reset();
  }
  // Pictures that did not come are stood for by the next one, so that the film takes the time that the run took.
  const double pictures = std::round(1e-9 * static_cast<double>(pose.t_ns - t_ns_) * rate_hz_);
  for (int i = 0; i < static_cast<int>(std::clamp(pictures, 1.0, kLongestStill)); ++i) video_->Add(picture);
  t_ns_ = pose.t_ns;
}

}  // namespace plslam
