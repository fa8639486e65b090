#pragma once

#include <vector>

#include "core/features/features.h"
#include "vo_process/options.h"
#include "vo_process/tracked_frame.h"

namespace plslam {

// What lists of point and of line landmarks have in common.

/// Descriptors of the landmarks seen within `max_unseen_frames`, and their places in the list.
struct KnownDescriptors {
  std::vector<Descriptor> descriptors;
  std::vector<int> owners;
};

template <class Landmark>
KnownDescriptors RecentDescriptors(const std::vector<Landmark>& landmarks, int max_unseen_frames) {
  KnownDescriptors known;
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    if (landmarks[i].unseen_frames > max_unseen_frames) continue;
    known.descriptors.push_back(landmarks[i].descriptor);
    known.owners.push_back(i);
  }
  return known;
}

/// Descriptors of stereo points or lines, in their order.
template <class Feature>
std::vector<Descriptor> SeenDescriptors(const std::vector<Feature>& features) {
  std::vector<Descriptor> seen;
  seen.reserve(features.size());
  for (const Feature& feature : features) seen.push_back(feature.left.descriptor);
  return seen;
}

/// Drops what has been out of sight, or missed in sight, for too long.
template <class Landmark>
void DropStale(const LandmarkOptions& options, std::vector<Landmark>& landmarks) {
  std::erase_if(landmarks, [&options](const Landmark& landmark) {
    return landmark.unseen_frames > options.max_unseen_frames || landmark.missed > options.max_missed;
  });
}

}  // namespace plslam
