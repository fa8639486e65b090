// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"

namespace plslam::vo {

// Operations on lists of matches, and on the lists that they index.

/// Returns one flag for each of `n` landmarks or features (`member`): set if it is matched.
std::vector<char> FlagsOf(const std::vector<LandmarkMatch>& matches, int LandmarkMatch::*member, size_t n);

/// Sets the flags of the matched features.
void Mark(const std::vector<LandmarkMatch>& matches, std::vector<char>& features);

/// Records in the frame's tracks that the matched features are on this body (-1: the world).
void NameMatched(const FrameMatches& matches, int body, TrackedFrame& frame);

/// Adds the matches of features that have none yet.
void AddMatches(const std::vector<LandmarkMatch>& more, std::vector<LandmarkMatch>& matches);

/// Returns the matches with new indices, after lists were shortened or split: new indices by the old ones. An empty
/// list keeps indices.
std::vector<LandmarkMatch> Renumbered(const std::vector<LandmarkMatch>& matches, const std::vector<int>& landmarks,
                                      const std::vector<int>& features);
FrameMatches Renumbered(const FrameMatches& matches, const std::vector<int>& points, const std::vector<int>& lines);

/// Returns the indices of the set flags, or of the others.
std::vector<int> PlacesOf(const std::vector<char>& flags, bool flagged);

/// Returns the coordinate-wise median of the matched landmarks; lines count with their midpoints.
Eigen::Vector3d MiddleOf(const LocalLandmarks& landmarks, const FrameMatches& matches);

template <class Feature>
std::vector<Feature> Chosen(const std::vector<Feature>& features, const std::vector<int>& which) {
  std::vector<Feature> chosen;
  chosen.reserve(which.size());
  for (const int i : which) chosen.push_back(features[i]);
  return chosen;
}

}  // namespace plslam::vo
