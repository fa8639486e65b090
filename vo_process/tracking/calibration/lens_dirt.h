// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "core/features/matching/descriptor_matcher.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/stereo/dirt_cells.h"

namespace plslam::vo {

/// A corner of one image, in rectified pixels.
struct LensCorner {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  bool is_matched = false;  ///< whether the other image shows it, too
};

/// Pixels of one image that do not follow the motion: dirt, drops and scratches on the lens, burnt-in text.
///
/// The corners of an image are compared with those of a reference image, a few frames before. Corners that stay at
/// their pixels belong to the lens, unless the camera stands. Two shares tell that: s_m of the corners that the other
/// image shows, too, and s_u of the others, which stay. A standing camera has a large s_m; a moving one has a small one, and
/// s_u then is the share of dirt. Each corner of the second kind that stays gains evidence in proportion to s_u - s_m,
/// less two standard deviations: much dirt is recognised at once, little dirt after some comparisons. In motion that
/// repeats hardly any matched corner, each gains a little in any case: what stays for a second is no chance. A cleaned
/// lens loses the evidence as the camera moves; while it stands, nothing is learned or forgotten.
class LensDirt {
 public:
  explicit LensDirt(const StereoCamera& camera);

  /// Learns from the corners of the next image.
  void Observe(const std::vector<LensCorner>& corners);

  bool HasDirt() const { return CoveredShare() > 0.0; }
  bool IsOnDirt(const Eigen::Vector2d& px) const;
  /// The regions within the reach of dirt; empty without dirt.
  DirtCells Cells() const;
  /// Share of the image that dirt covers, in cells of 8 x 8 pixels with dirty corners; 0 without dirt.
  double CoveredShare() const;
  /// A pixel on the largest spot; call it only if there is dirt.
  Eigen::Vector2d Place_px() const;

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.reference_, self.reference_frames_, self.spots_);
  }

 private:
  /// A corner of the reference image.
  struct Corner {
    float u_px = 0.0F;
    float v_px = 0.0F;
    bool is_matched = false;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.u_px, self.v_px, self.is_matched);
    }
  };

  /// The first corner of a cell that stayed.
  struct Spot {
    float u_px = 0.0F;
    float v_px = 0.0F;
    float evidence = 0.0F;
    bool is_dirt = false;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.u_px, self.v_px, self.evidence, self.is_dirt);
    }
  };

  void Learn(const PointGrid& grid, const std::vector<LensCorner>& corners, float gain);
  int CellOf(const Eigen::Vector2d& px) const;
  /// Calls visit(spot) for each spot of dirt up to `reach` cells away.
  template <class Visit>
  void ForEachDirtAround(int cell, int reach, const Visit& visit) const;

  int columns_;
  int rows_;
  std::vector<Corner> reference_;
  int reference_frames_ = 0;       ///< since the reference image
  std::map<int32_t, Spot> spots_;  ///< by cell, row by row
};

}  // namespace plslam::vo
