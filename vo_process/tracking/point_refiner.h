#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/stereo/image_levels.h"
#include "vo_process/stereo/patch_tracker.h"
#include "vo_process/tracking/point_landmarks.h"

namespace plslam {

/// What a feature is measured to be after refinement: index into the frame's points, and its new value.
struct RefinedPoint {
  int feature = -1;
  StereoPoint point;
};

/// Holds on to the place on the surface that a landmark was founded at.
///
/// ORB finds a corner again to a pixel or so, and the place it finds slides with the point of view. The refiner keeps the
/// patch of the image that each landmark was founded in, turns and stretches it as the motion since and the slant of
/// the surface ask for, and aligns it with the frame. The slant is the mean of what stereo said of it in the frames since.
/// Values in, values out; the same for the same input.
class PointRefiner {
 public:
  PointRefiner(const StereoCamera& camera, const RefinementOptions& options) : camera_(camera), options_(options) {}

  /// Those of the matched features that could be refined, seen from about `T_odom_c`. The disparity goes along with the
  /// slant of the surface. None where there is no image.
  std::vector<RefinedPoint> Refine(const PointLandmarks& landmarks, const std::vector<LandmarkMatch>& matches,
                                   const TrackedFrame& frame, const SE3& T_odom_c) const;

  /// Learns from a frame whose tracks name their landmarks: patches of those that it founded, slants of the others.
  /// Forgets landmarks that are not among `alive`.
  void Remember(const std::vector<const PointLandmarks*>& alive, const SE3& T_odom_c, const TrackedFrame& frame);

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.references_);
  }

 private:
  /// How the disparity changes by a pixel along u and v, and inverse variances of that.
  struct Slope {
    Eigen::Vector2d value = Eigen::Vector2d::Zero();
    Eigen::Vector2d information = Eigen::Vector2d::Zero();

    void Add(const Slope& other);

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.value, self.information);
    }
  };
  /// A landmark's first sight.
  struct Reference {
    int64_t landmark_id = -1;
    SE3 T_ref_odom;
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    PatchPixels pixels;
    Slope slope;
    /// Made of the pixels once the landmark has been seen again: many never are.
    std::shared_ptr<const ReferencePatch> patch;

    static bool Before(const Reference& a, const Reference& b) { return a.landmark_id < b.landmark_id; }
    void MakePatch();

    /// The patch follows from the pixels.
    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      bool has_patch = self.patch != nullptr;
      a(self.landmark_id, self.T_ref_odom, self.px, self.pixels.size_px, self.pixels.off_center, self.pixels.pixels,
        self.slope, has_patch);
      if constexpr (!std::is_const_v<Self>) {
        if (has_patch) self.MakePatch();
      }
    }
  };

  Reference* Find(int64_t landmark_id);
  const Reference* Find(int64_t landmark_id) const;
  std::optional<StereoPoint> RefineOne(const Reference& reference, const PointLandmark& landmark,
                                       const TrackedFrame& frame, const StereoPoint& seen, const SE3& T_c_odom) const;
  std::optional<Eigen::Matrix2d> Shape(const Reference& reference, const Eigen::Vector3d& p_odom,
                                       const SE3& T_c_odom) const;
  static Slope SlopeOf(const StereoPoint& seen);
  std::optional<Slope> SlopeFrom(const Reference& reference, const StereoPoint& seen, const SE3& T_odom_c) const;
  void Learn(const StereoPoint& seen, const SE3& T_odom_c, Reference& reference) const;
  void Forget(const std::vector<const PointLandmarks*>& alive);

  StereoCamera camera_;
  RefinementOptions options_;
  /// By ascending landmark.
  std::vector<Reference> references_;
};

}  // namespace plslam
