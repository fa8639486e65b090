// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "vo_process/tracking/local_landmarks.h"
#include "vo_process/tracking/tracked_frame.h"

namespace plslam::vo {

// Lists of matches, and parts of lists that they name.

/// One flag for each of `n` landmarks or features (`member`): set where a match has it.
std::vector<char> FlagsOf(const std::vector<LandmarkMatch>& matches, int LandmarkMatch::*member, size_t n);

/// Sets the flags of the features.
void Mark(const std::vector<LandmarkMatch>& matches, std::vector<char>& features);

/// Puts down in the frame's tracks that the features are on that body (-1: the world).
void NameMatched(const FrameMatches& matches, int body, TrackedFrame& frame);

/// Adds those that are not there yet.
void AddMatches(const std::vector<LandmarkMatch>& more, std::vector<LandmarkMatch>& matches);

/// The same matches after lists were shortened or cut out: new places by the old ones. An empty list leaves numbers as
/// they are.
std::vector<LandmarkMatch> Renumbered(const std::vector<LandmarkMatch>& matches, const std::vector<int>& landmarks,
                                      const std::vector<int>& features);
FrameMatches Renumbered(const FrameMatches& matches, const std::vector<int>& points, const std::vector<int>& lines);

/// Places in `flags` of what is flagged, or of what is not.
std::vector<int> PlacesOf(const std::vector<char>& flags, bool flagged);

/// The median of the landmarks that were matched, each coordinate by itself; lines by their middles.
Eigen::Vector3d MiddleOf(const LocalLandmarks& landmarks, const FrameMatches& matches);

template <class Feature>
std::vector<Feature> Chosen(const std::vector<Feature>& features, const std::vector<int>& which) {
  std::vector<Feature> chosen;
  chosen.reserve(which.size());
  for (const int i : which) chosen.push_back(features[i]);
  return chosen;
}

}  // namespace plslam::vo
