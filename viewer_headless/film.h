// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/map/map.h"
#include "viewer_headless/final_trajectory.h"
#include "viewer_headless/recorder.h"
#include "viewer_headless/video/run_video.h"
#include "viewer_headless/video/top_view.h"

namespace plslam::viewer {

/// The path of a film so far. What was published stays where it was when the map is corrected, so that path and
/// landmarks would come apart: positions are kept as odometry saw them, and each moves with a keyframe.
class FilmPath {
 public:
  /// Frames without an estimated pose (HasPose) are no part of it.
  void Add(const FramePose& pose);

  /// Positions in w, in the map as it is now, in the order they came in. A frame moves as the last keyframe of its
  /// session up to it has been moved, or else the first one after; not across lost frames, since nobody knows what
  /// lies between. Where that leaves none the frame stays as published. (FinalPoses, which know what comes next,
  /// blend between two keyframes: a path in a film would creep with each new one.)
  std::vector<Eigen::Vector3d> In(const Map& map) const;

 private:
  struct Step {
    int64_t frame_id = 0;
    int64_t session = 0;
    Eigen::Vector3d p_odom;
    Eigen::Vector3d p_w;  ///< as published
  };

  const SE3* CorrectionOf(const Step& step, const FrameCorrections& corrections) const;
  bool IsLostBetween(int64_t from, int64_t to) const;

  std::vector<Step> steps_;
  std::set<int64_t> lost_frames_;
};

/// The film of a run: what the camera sees with its features, and beside it the map from above as it was then, with
/// the path so far in it.
class Film {
 public:
  explicit Film(std::string path) : path_(std::move(path)), program_(StartFilm(path_)) {}
  /// Of one that is not finished no file is left.
  ~Film() = default;
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  /// Pictures a second of the camera, before the first picture; without that, or with 0, the first two pictures tell.
  void SetRate(double camera_rate_hz) { camera_rate_hz_ = camera_rate_hz; }
  /// `overlay` as DrawOverlay draws it. Where nothing can be written the log says so, once, and `Finish` says it
  /// again.
  void Add(const FramePose& pose, const cv::Mat& overlay, const Map& map);
  /// No more pictures: puts the film in place, and says in the log what there is. Throws std::runtime_error where
  /// there is no film.
  void Finish();

 private:
  struct Waiting {
    FramePose pose;
    cv::Mat picture;
  };
  void Write(const FramePose& pose, const cv::Mat& picture);
  void Begin(const Waiting& first, double rate_hz);
  void Open(double rate_hz, const cv::Size& size);

  std::string path_;
  /// Until the first picture comes.
  std::unique_ptr<FilmProcess> program_;
  /// Why there is no film.
  std::optional<std::string> failure_;
  TopViewWindow window_;
  FilmPath positions_;
  /// From the map as it was when it had so many keyframes.
  Eigen::Quaterniond q_level_w_ = Eigen::Quaterniond::Identity();
  size_t levelled_keyframes_ = 0;
  std::optional<Waiting> first_;
  std::unique_ptr<RunVideo> video_;
  double camera_rate_hz_ = 0.0;
  double rate_hz_ = 0.0;
  int64_t began_ns_ = 0;  ///< time of the first picture, or of the first one after the time went back
  int64_t t_ns_ = 0;
  double shown_ = 0.0;  ///< pictures since `began_ns_`
};

}  // namespace plslam::viewer
