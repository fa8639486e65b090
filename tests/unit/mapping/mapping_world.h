// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/keyframe.h"
#include "core/map/map.h"
#include "mapping_process/mapper.h"
#include "tests/support/feature_world.h"

namespace plslam::test {

/// Observation of a walk: noise of the features and of the tracker's motion from keyframe to keyframe.
struct WalkOptions {
  double noise_px = 0.4;
  double motion_sigma_m = 0.01;
  double motion_sigma_rad = 0.004;
  /// Features have the tracker's ids (those of the world), or none.
  bool with_ids = true;
  SessionId session = 7;
  uint64_t seed = 1;
};

/// Keyframes along a path and their true poses. The first one's odometry is the truth, so the map's frame is the
/// world's.
struct Walk {
  std::vector<Keyframe> keyframes;
  std::vector<SE3> T_w_c;
};

Walk MakeWalk(const FeatureWorld& world, const std::vector<SE3>& path, const WalkOptions& options);

/// A keyframe with these features and no ids, after `previous` of its session (nullptr: the first, at `T_odom_kf`).
Keyframe MakeKeyframe(const Keyframe* previous, const SE3& T_odom_kf, StereoFeatures features);

/// A curve through the middle of the default world, turning.
std::vector<SE3> TurningPath(int n);

/// A corridor of points and edges on its walls, 8 m of it in view, along z; and a path down its middle.
FeatureWorld MakeCorridor(double length_m, double points_per_m, double lines_per_m, uint64_t seed);
std::vector<SE3> CorridorPath(int n, double step_m);

/// Insert, adjust, cull, as mapping_process does for each keyframe of a lockstep stream.
bool MapOne(const Keyframe& keyframe, mapping::Mapper& mapper, std::string* reason = nullptr);
mapping::Mapper MapAll(const std::vector<Keyframe>& keyframes, const mapping::MappingOptions& options = {});

/// Returns the defects of a map in words, empty if there are none: non-finite numbers, invalid covariances,
/// observations of keyframes or features that do not exist or show another landmark, an invalid spanning tree.
std::string WrongWith(const Map& map);

/// Number of landmarks whose covariance is zero: no measured value is known exactly.
int ExactlyKnown(const Map& map);

/// Returns the map as sent over the wire. Throws std::invalid_argument for content that readers reject.
std::vector<uint8_t> Encoded(const MapUpdate& update);
/// All of a map, whatever led to it.
std::vector<uint8_t> Encoded(const Map& map);

/// Root mean square of the distances between the keyframes and the truth, m. By the keyframe's number in its session.
double PositionError_m(const Map& map, const std::vector<SE3>& T_w_c);
/// The same of the tracker's own poses.
double OdometryError_m(const Walk& walk);

/// Distances of the map's landmarks from those of the world with the same descriptor; of lines the larger of the
/// distances of its ends to the infinite line. Ascending.
std::vector<double> PointErrors_m(const Map& map, const FeatureWorld& world);
std::vector<double> LineErrors_m(const Map& map, const FeatureWorld& world);

Descriptor DescriptorOf(uint64_t seed);

}  // namespace plslam::test
