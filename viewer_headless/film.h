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

#include "core/ids/ids.h"
#include "core/map/map.h"
#include "core/run/final_trajectory.h"
#include "core/run/recorder.h"
#include "viewer_headless/video/run_video.h"
#include "viewer_headless/video/top_view.h"

namespace plslam::viewer {

/// The path of a film so far. Published poses are not updated when the map is corrected, so that path and landmarks
/// would drift apart: positions are stored in the odometry frame, and each moves with a keyframe.
class FilmPath {
 public:
  /// Adds a frame; frames without an estimated pose (HasPose) are not part of the path.
  void Add(const FramePose& pose);

  /// Returns the positions in w, in the current map, in the order in which they were added. A frame moves with the last
  /// keyframe of its session up to it, or else with the first one after it; not across lost frames, since the motion in
  /// between is unknown. A frame without such a keyframe stays as published. (FinalPoses, which have the later
  /// keyframes too, blend between two keyframes: a path in a film would creep with each new one.)
  std::vector<Eigen::Vector3d> In(const Map& map) const;

 private:
  struct Step {
    FrameId frame_id = 0;
    SessionId session;
    Eigen::Vector3d p_odom;
    Eigen::Vector3d p_w;  ///< as published
  };

  const SE3* CorrectionOf(const Step& step, const FrameCorrections& corrections) const;
  /// Returns the first lost frame from this one on; the largest id if there is none.
  FrameId NextLost(FrameId from) const;

  std::vector<Step> steps_;
  std::set<FrameId> lost_frames_;
};

/// The film of a run: the camera image with its features, and beside it the map at that time from above, with the path
/// so far.
class Film {
 public:
  explicit Film(std::string path) : path_(std::move(path)), program_(StartFilm(path_)) {}
  /// An unfinished film leaves no file.
  ~Film() = default;
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  /// Sets the picture rate of the camera, before the first picture; without it, or with 0, the first two pictures
  /// determine the rate.
  void SetRate(double camera_rate_hz) { camera_rate_hz_ = camera_rate_hz; }
  /// Adds a picture; `overlay` is drawn by DrawOverlay. If the film cannot be written, the log reports it once, and
  /// `Finish` throws the same sentence.
  void Add(const FramePose& pose, const cv::Mat& overlay, const Map& map);
  /// Completes the film after the last picture, gives it its final name, and logs it. Throws std::runtime_error if
  /// there is no film.
  void Finish();
  /// The sentence about a requested file that is a folder of pictures instead; empty if it is as requested.
  const std::string& note() const { return note_; }

 private:
  struct Waiting {
    FramePose pose;
    cv::Mat picture;
  };
  void Write(const FramePose& pose, const cv::Mat& picture);
  void Begin(const Waiting& first, double rate_hz);
  void Open(double rate_hz, const cv::Size& size);

  std::string path_;
  std::string note_;
  /// Empty after the first picture.
  std::unique_ptr<FilmProcess> program_;
  /// The reason why there is no film.
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
