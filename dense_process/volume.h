// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace plslam::dense {

/// A measured surface point, seen from the eye of its camera.
struct DepthRay {
  Eigen::Vector3d end;
  float weight = 1.0F;  ///< at most 1, for a depth known to a fraction of a voxel
  float grey = 0.0F;
  /// Cosine of the angle between the ray and the normal of the surface.
  float incidence = 1.0F;
};

/// Truncated signed distances in sparse voxels (Curless and Levoy 1996), stored in an OpenVDB tree.
///
/// Voxel (i, j, k) has its centre at voxel_m * (i, j, k) of the volume's frame. Its distance is positive in front of a
/// surface and negative behind it, within a truncation of three voxels. Voxels that no ray has crossed are unknown, and
/// so is everything deeper behind a surface than the truncation.
class Volume {
 public:
  /// Truncation of distances, in voxels.
  static constexpr double kTruncation = 3.0;
  /// Weight below which a voxel is unknown: the rounding of sums.
  static constexpr float kLeastWeight = 1e-3F;

  struct Voxel {
    Eigen::Vector3i index;
    float distance_m = 0.0F;
    float weight = 0.0F;
    float grey = 0.0F;
  };

  explicit Volume(double voxel_m);
  ~Volume();
  Volume(Volume&& other) noexcept;
  Volume& operator=(Volume&& other) noexcept;

  double voxel_m() const { return voxel_m_; }
  Eigen::Vector3d Centre(const Eigen::Vector3i& index) const { return voxel_m_ * index.cast<double>(); }

  /// Adds the rays of one image: free space from the eye to each surface point, and the surface itself. A later image
  /// that sees through a surface of an earlier one removes it, as far as its weights outweigh those before.
  void Integrate(const Eigen::Vector3d& eye, std::span<const DepthRay> rays);

  /// Removes obstacles along rays from the eye to ends up to which nothing is: only voxels with a surface change, and unknown
  /// ones stay unknown.
  void Clear(const Eigen::Vector3d& eye, std::span<const Eigen::Vector3d> ends);

  /// Adds another volume of the same voxel size, moved rigidly; interpolates between its voxels unless the motion is
  /// negligible.
  void Add(const Volume& other, const SE3& T_this_other);

  /// Calls `visit` for each known voxel, in a fixed order.
  void Visit(const std::function<void(const Voxel&)>& visit) const;

  /// A block of 8 x 8 x 8 voxels, for files.
  struct Block {
    std::array<int32_t, 3> origin{};  ///< of its first voxel; multiples of 8
    std::array<uint64_t, 8> known{};  ///< a bit for each voxel, in the order of OpenVDB: z fastest
    std::vector<float> sums;          ///< three for each known voxel: weight * distance, weight, weight * grey

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.origin, self.known, self.sums);
    }
  };
  /// The volume as blocks, in a fixed order, and back. `FromBlocks` throws std::runtime_error for values that no volume
  /// has.
  std::vector<Block> Blocks() const;
  static Volume FromBlocks(double voxel_m, std::span<const Block> blocks);

  size_t n_voxels() const;
  size_t bytes() const;

  /// Reads single voxels; as long as the volume does not change.
  class Reader {
   public:
    explicit Reader(const Volume& volume);
    ~Reader();
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    /// Returns nullopt for an unknown voxel.
    std::optional<Voxel> At(const Eigen::Vector3i& index) const;

   private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

 private:
  struct Impl;
  double voxel_m_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam::dense
