// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/stereo_camera.h"
#include "core/map/surface_cloud.h"
#include "dense_process/depth.h"
#include "dense_process/keyframe_poses.h"
#include "dense_process/packed_volume.h"
#include "dense_process/surface.h"
#include "dense_process/volume.h"

namespace plslam::dense {

/// The robot for which grids are made, in the file of surfaces for exports.
struct Robot {
  double height_m = 1.0;
  std::vector<double> up_c;  ///< as for `VerticalOf`

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.height_m, self.up_c);
  }
};

/// Surfaces of a map in submaps of a few keyframes, each anchored to the first one that the map knows. A correction of
/// the map moves the submaps rigidly with their anchors, at no cost; within a submap the poses at the time of fusion remain. All but the newest
/// are packed.
///
/// A blank surface has no depth, but its surroundings bound it from below. Such rays clear obstacles of their own and of
/// earlier submaps when these are merged: a person who has left the front of a blank wall. They make nothing free that was
/// unknown.
///
/// Surfaces stay as long as keyframes of the map see them. A map removes a keyframe because others show the same: its
/// surface then moves with one of those. Or it forgets a place: the surface is removed, because the place would be
/// mapped again elsewhere, with the drift since then.
class DenseMap {
 public:
  /// `range_m`: largest depth in use; 0: where it is known to 2.5 voxels.
  DenseMap(double voxel_m, double range_m) : voxel_m_(voxel_m), range_m_(range_m) {}

  double voxel_m() const { return voxel_m_; }
  const Robot& robot() const { return robot_; }
  void SetRobot(Robot robot) { robot_ = std::move(robot); }
  size_t n_submaps() const;
  size_t n_keyframes() const { return fused_.size(); }
  size_t bytes() const;
  /// Memory for each cubic metre of known space, free or not; 0 without any.
  double BytesPerCubicMetre() const;

  /// Fuses the depth of a keyframe. Returns false if `poses` lacks the keyframe.
  bool Add(const KeyframeFrame& keyframe, const DepthImage& depth, const cv::Mat& grey, const StereoCamera& camera,
           const KeyframePoses& poses);

  /// Follows keyframes that the map has removed; `lasting` are those that it has. A submap none of whose keyframes
  /// remains joins the one of the keyframe that sees most of its surface, and is removed if all keyframes together see
  /// less than half of it. The newest submap, which still grows, stays, and so does one with keyframes of unknown
  /// place: a map that is being rebuilt lacks keyframes that it did not remove.
  void FollowRemovals(const KeyframePoses& poses, const KeyframePoses& lasting, const StereoCamera& camera);

  /// Returns whether the depth of the keyframe was fused, also by a process before this one.
  bool Has(const KeyframeFrame& keyframe) const { return fused_.contains(keyframe); }

  /// The same of any keyframe of a session.
  bool HasSession(SessionId session) const {
    const auto first = fused_.lower_bound({session, FrameId(std::numeric_limits<int64_t>::min())});
    return first != fused_.end() && first->first == session;
  }

  /// The keyframes of the submaps.
  std::set<KeyframeFrame> Members() const;

  /// Writes a file of surfaces (a sealed file, core/files/sealed_file.h) that continues with the map. `lasting`: the
  /// keyframes that the map will have then; submaps without any of them are anchored to the nearest one.
  /// Throws std::runtime_error that names the file.
  void Write(const std::string& path, const KeyframePoses& poses, const KeyframePoses& lasting) const;
  /// Reads such a file. Throws std::runtime_error, in one sentence that names the file, if it is damaged, of another
  /// type, or has impossible values.
  static DenseMap Read(const std::string& path, double range_m);

  /// Number of submaps without a place: the map has none of their keyframes.
  size_t CountUnplaced(const KeyframePoses& poses) const;

  /// Returns all submaps in one volume, with the anchors at `poses`, in a frame `a`. Submaps without a place are left
  /// out.
  Volume Merge(const KeyframePoses& poses, const SE3& T_a_w) const;

  /// Returns the vertices of the merged surface in w as points of the submaps that know their places: the first one of
  /// several, so that later submaps leave it unchanged. A point whose place no submap knows goes to the newest one.
  SurfaceCloud Split(const Surface& surface_w, const KeyframePoses& poses) const;

 private:
  /// Rays of a keyframe through blank pixels, which are known to be free up to their ends, in s.
  struct BoundedView {
    size_t submap = 0;  ///< number of the submap of that time, which may have joined another since
    Eigen::Vector3f eye = Eigen::Vector3f::Zero();
    std::vector<Eigen::Vector3f> ends;
  };
  struct Member {
    KeyframeFrame keyframe;
    SE3 T_s_kf;  ///< s: the frame w of the map at the time of the submap's first keyframe

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.keyframe, self.T_s_kf);
    }
  };
  struct Submap {
    std::vector<Member> members;    ///< empty: the submap has been removed, or has joined another
    std::optional<Volume> growing;  ///< the voxels of the newest submap
    PackedVolume packed;            ///< those of all others, which are only read
    std::vector<BoundedView> views;
  };
  struct StoredSubmap;

  class Voxels;
  static const Member* AnchorOf(const Submap& submap, const KeyframePoses& poses);
  static std::optional<SE3> PoseOf(const Submap& submap, const KeyframePoses& poses);
  void Join(Submap& gone, const SE3& T_to_gone, Submap& to) const;
  static void Empty(Submap& gone);
  bool Continues(const KeyframeFrame& keyframe, const SE3& T_w_kf, const KeyframePoses& poses) const;

  double voxel_m_;
  double range_m_;
  Robot robot_;
  std::vector<Submap> submaps_;
  std::set<KeyframeFrame> fused_;
};

}  // namespace plslam::dense
