// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>

#include "core/ids/ids.h"
#include "vo_process/tracking/landmarks/line_landmarks.h"
#include "vo_process/tracking/landmarks/point_landmarks.h"

namespace plslam::vo {

/// Matches of both feature types.
struct FrameMatches {
  std::vector<LandmarkMatch> points;
  std::vector<LandmarkMatch> lines;

  /// Inlier score: lines count twice, because each has two endpoints.
  int Weight() const { return static_cast<int>(points.size() + 2 * lines.size()); }
};

/// Points and lines tracked by odometry.
struct LocalLandmarks {
  LocalLandmarks(const StereoCamera& camera, const VoOptions& options)
      : points(camera, options.features.orb, options.landmarks), lines(camera, options.landmarks) {}
  LocalLandmarks(PointLandmarks some_points, LineLandmarks some_lines)
      : points(std::move(some_points)), lines(std::move(some_lines)) {}

  PointLandmarks points;
  LineLandmarks lines;
  TrackId next_point_id = 0;
  TrackId next_line_id = 0;

  /// Continues the numbering of new landmarks after that of `others`.
  void ContinueNumbering(const LocalLandmarks& others) {
    next_point_id = others.next_point_id;
    next_line_id = others.next_line_id;
  }

  void Update(const SE3& T_odom_c, const FrameMatches& matches, TrackedFrame& frame) {
    points.Update(T_odom_c, matches.points, frame);
    lines.Update(T_odom_c, matches.lines, frame);
  }
  void Adopt(const TrackerLocalMap& local_map) {
    const SE3 T_odom_w = local_map.T_w_odom.Inverse();
    points.Adopt(T_odom_w, local_map.points, local_map.f_px, next_point_id);
    lines.Adopt(T_odom_w, local_map.lines, next_line_id);
  }
  void Move(const SE3& T_new_odom) {
    points.Move(T_new_odom);
    lines.Move(T_new_odom);
  }
  /// Makes all landmarks take part in the next search, as if the last frame had observed them.
  void CountAsSeen() {
    points.CountAsSeen();
    lines.CountAsSeen();
  }
  /// Moves the flagged landmarks of each feature type to a list of their own.
  LocalLandmarks Take(const std::vector<char>& taken_points, const std::vector<char>& taken_lines) {
    return {points.Take(taken_points), lines.Take(taken_lines)};
  }
  LocalLandmarks Copy(const std::vector<char>& chosen_points, const std::vector<char>& chosen_lines) const {
    return {points.Copy(chosen_points), lines.Copy(chosen_lines)};
  }
  void Append(const LocalLandmarks& others) {
    points.Append(others.points);
    lines.Append(others.lines);
  }
  void Create(const SE3& T_odom_c, TrackedFrame& frame, int body = -1) {
    points.Create(T_odom_c, frame, next_point_id, body);
    lines.Create(T_odom_c, frame, next_line_id, body);
  }
  void Initialise(const SE3& T_odom_c, TrackedFrame& frame) {
    points.Initialise(T_odom_c, frame, next_point_id);
    lines.Initialise(T_odom_c, frame, next_line_id);
  }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.points, self.lines, self.next_point_id, self.next_line_id);
  }
};

}  // namespace plslam::vo
