// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/map/map.h"
#include "core/map/surface_cloud.h"
#include "dense_process/depth.h"
#include "dense_process/surface.h"
#include "dense_process/volume.h"

namespace plslam::dense {

/// Session and frame of a keyframe: a name that stays when the map is rebuilt.
using KeyframeFrame = std::pair<SessionId, FrameId>;
using KeyframePoses = std::map<KeyframeFrame, SE3>;  ///< T_w_kf

/// Returns the poses of the keyframes of the map.
KeyframePoses LastingPosesOf(const Map& map);
/// The same, and of those that were removed if the map remembers them.
KeyframePoses PosesOf(const Map& map);

/// Surfaces of a map in submaps of a few keyframes, each anchored to its first one. A correction of the map moves the
/// submaps rigidly with their anchors, at no cost; within a submap the poses at the time of fusion remain.
///
/// A blank surface has no depth, but its surroundings bound it from below. Such rays clear obstacles of all submaps when
/// these are merged: a person who has left the front of a blank wall. They make nothing free that was unknown.
class DenseMap {
 public:
  /// `range_m`: largest depth in use; 0: where it is known to 2.5 voxels.
  DenseMap(double voxel_m, double range_m) : voxel_m_(voxel_m), range_m_(range_m) {}

  double voxel_m() const { return voxel_m_; }
  size_t n_submaps() const { return submaps_.size(); }
  size_t n_keyframes() const { return fused_.size(); }
  size_t bytes() const;

  /// Fuses the depth of a keyframe. Returns false if `poses` lacks the keyframe.
  bool Add(const KeyframeFrame& keyframe, const DepthImage& depth, const cv::Mat& grey, const StereoCamera& camera,
           const KeyframePoses& poses);

  /// Returns whether the depth of the keyframe was fused, also by a process before this one.
  bool Has(const KeyframeFrame& keyframe) const { return fused_.contains(keyframe); }

  /// Writes a file of surfaces (a sealed file, core/files/sealed_file.h) that continues with the map. `lasting`: the
  /// keyframes that the map will have then; submaps whose anchor is not among them are anchored to the nearest one.
  /// Throws std::runtime_error that names the file.
  void Write(const std::string& path, const KeyframePoses& poses, const KeyframePoses& lasting) const;
  /// Reads such a file. Throws std::runtime_error, in one sentence that names the file, if it is damaged, of another type,
  /// or has impossible values.
  static DenseMap Read(const std::string& path, double range_m);

  /// Returns all submaps in one volume, with the anchors at `poses`, in a frame `a`. Submaps whose anchor is unknown are
  /// left out.
  Volume Merge(const KeyframePoses& poses, const SE3& T_a_w) const;

  /// Returns the vertices of the merged surface in w as points of the submaps that know their places: the first one of
  /// several, so that later submaps leave it unchanged. A point whose place no submap knows goes to the newest one.
  SurfaceCloud Split(const Surface& surface_w, const KeyframePoses& poses) const;

 private:
  /// Rays of a keyframe through blank pixels, which are known to be free up to their ends, in s.
  struct BoundedView {
    Eigen::Vector3f eye = Eigen::Vector3f::Zero();
    std::vector<Eigen::Vector3f> ends;
  };
  struct Submap {
    KeyframeFrame anchor;
    SE3 T_s_anchor;  ///< s: the frame w of the map at the time of the first keyframe
    int n_keyframes = 0;
    Volume volume;
    std::vector<BoundedView> views;
  };

  bool Continues(const KeyframeFrame& keyframe, const SE3& T_w_kf, const KeyframePoses& poses) const;

  double voxel_m_;
  double range_m_;
  std::vector<Submap> submaps_;
  std::set<KeyframeFrame> fused_;
};

}  // namespace plslam::dense
