// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/match_lists.h"

#include <algorithm>
#include <array>

#include "core/motion/robust.h"

namespace plslam::vo {

std::vector<char> FlagsOf(const std::vector<LandmarkMatch>& matches, int LandmarkMatch::*member, size_t n) {
  std::vector<char> flags(n, 0);
  for (const LandmarkMatch& match : matches) flags[match.*member] = 1;
  return flags;
}

void Mark(const std::vector<LandmarkMatch>& matches, std::vector<char>& features) {
  for (const LandmarkMatch& match : matches) features[match.feature] = 1;
}

void NameMatched(const FrameMatches& matches, int body, TrackedFrame& frame) {
  for (const LandmarkMatch& match : matches.points) frame.point_tracks[match.feature].body = body;
  for (const LandmarkMatch& match : matches.lines) frame.line_tracks[match.feature].body = body;
}

void AddMatches(const std::vector<LandmarkMatch>& more, std::vector<LandmarkMatch>& matches) {
  for (const LandmarkMatch& match : more) {
    const bool known = std::any_of(matches.begin(), matches.end(), [&](const LandmarkMatch& m) {
      return m.landmark == match.landmark && m.feature == match.feature;
    });
    if (!known) matches.push_back(match);
  }
}

std::vector<LandmarkMatch> Renumbered(const std::vector<LandmarkMatch>& matches, const std::vector<int>& landmarks,
                                      const std::vector<int>& features) {
  std::vector<LandmarkMatch> result;
  result.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    result.push_back({landmarks.empty() ? match.landmark : landmarks[match.landmark],
                      features.empty() ? match.feature : features[match.feature]});
  }
  return result;
}

FrameMatches Renumbered(const FrameMatches& matches, const std::vector<int>& points, const std::vector<int>& lines) {
  return {Renumbered(matches.points, points, {}), Renumbered(matches.lines, lines, {})};
}

std::vector<int> PlacesOf(const std::vector<char>& flags, bool flagged) {
  std::vector<int> places;
  for (size_t i = 0; i < flags.size(); ++i) {
    if ((flags[i] != 0) == flagged) places.push_back(static_cast<int>(i));
  }
  return places;
}

Eigen::Vector3d MiddleOf(const LocalLandmarks& landmarks, const FrameMatches& matches) {
  std::array<std::vector<double>, 3> coordinates;
  const auto add = [&coordinates](const Eigen::Vector3d& p) {
    for (int i = 0; i < 3; ++i) coordinates[static_cast<size_t>(i)].push_back(p[i]);
  };
  for (const LandmarkMatch& match : matches.points) add(landmarks.points.landmarks()[match.landmark].p_odom);
  for (const LandmarkMatch& match : matches.lines) {
    const Segment3& segment = landmarks.lines.landmarks()[match.landmark].segment_odom;
    add(0.5 * (segment.p + segment.q));
  }
  return {Median(coordinates[0]), Median(coordinates[1]), Median(coordinates[2])};
}

}  // namespace plslam::vo
