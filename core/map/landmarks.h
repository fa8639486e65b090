// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/triangulation.h"
#include "core/ids/ids.h"

namespace plslam {

/// Observation of a landmark in a keyframe: index into the keyframe's points or lines. A map has most of these, so both
/// numbers share 64 bits.
struct Observation {
  static constexpr int kIdBits = 40;
  static constexpr int64_t kMaxId = (int64_t{1} << (kIdBits - 1)) - 1;
  static constexpr int32_t kMaxFeature = (1 << (63 - kIdBits)) - 1;

  Observation() = default;
  /// Neither number may exceed its maximum.
  Observation(KeyframeId of_keyframe, int32_t of_feature) {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
    keyframe_id_ = of_keyframe.value;
    feature = of_feature;
#pragma GCC diagnostic pop
  }

  KeyframeId keyframe_id() const { return KeyframeId(int64_t{keyframe_id_}); }

  bool operator==(const Observation&) const = default;

  int32_t feature : 64 - kIdBits = -1;

 private:
  int64_t keyframe_id_ : kIdBits = -1;  // A bit field cannot be a KeyframeId.
};
static_assert(sizeof(Observation) == sizeof(int64_t));

/// A covariance in single precision, as in messages: the upper triangle. Values beyond the range of float stay finite.
class LandmarkCovariance {
 public:
  LandmarkCovariance() = default;
  // NOLINTBEGIN(google-explicit-constructor): converts like a matrix, except for its precision.
  template <class Derived>
  LandmarkCovariance(const Eigen::MatrixBase<Derived>& covariance) {
    Set(covariance);
  }
  operator Eigen::Matrix3d() const { return matrix(); }
  // NOLINTEND(google-explicit-constructor)
  Eigen::Matrix3d matrix() const {
    const auto& [xx, xy, xz, yy, yz, zz] = upper_;
    Eigen::Matrix3d full;
    full << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return full;
  }

  bool operator==(const LandmarkCovariance&) const = default;

 private:
  void Set(const Eigen::Matrix3d& covariance) {
    constexpr double kMax = std::numeric_limits<float>::max();
    size_t i = 0;
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) {
        const double value = covariance(row, column);
        upper_[i++] = static_cast<float>(std::isfinite(value) ? std::clamp(value, -kMax, kMax) : value);
      }
    }
  }

  std::array<float, 6> upper_{};
};

/// The keyframe with which a landmark moves in a correction: the middle one of its observers, which is nearest to all
/// of them; -1 without observations.
inline KeyframeId AnchorOf(const std::vector<Observation>& observations) {
  return observations.empty() ? -1 : observations[observations.size() / 2].keyframe_id();
}

/// A point of the map. Sibling of `MapLine`.
struct MapPoint {
  /// 0, 1, 2, ... among points; never assigned again.
  LandmarkId id = -1;
  /// Position in the map frame, and its covariance given the poses of the observing keyframes.
  Eigen::Vector3d p_w = Eigen::Vector3d::Zero();
  LandmarkCovariance covariance;
  /// Descriptor and angle of the observation nearest to all others (PL-SLAM §V.A), its octave, and the depth in metres
  /// from which the camera of the map would detect it in that octave.
  Descriptor descriptor{};
  float angle_rad = 0.0F;
  int octave = 0;
  double depth_m = 1.0;
  /// Ascending by keyframe, each keyframe once.
  std::vector<Observation> observations;
};

/// A line segment of the map. Sibling of `MapPoint`.
struct MapLine {
  /// 0, 1, 2, ... among lines; never assigned again.
  LandmarkId id = -1;
  /// Endpoints in the map frame, directed with the brighter side on the right in the image; covariances given the poses
  /// of the observing keyframes. The endpoints show the observed extent; only directions across the line are measured.
  Segment3 segment_w;
  LandmarkCovariance covariance_p;
  LandmarkCovariance covariance_q;
  Descriptor descriptor{};
  std::vector<Observation> observations;
};

/// Ids of points and lines, ascending.
struct LandmarksNamed {
  std::vector<LandmarkId> points;
  std::vector<LandmarkId> lines;
};

/// Moves a landmark by T_new_old, a displacement of the map frame; rotates covariances, too.
inline void MoveRigidly(const SE3& T_new_old, MapPoint& point) {
  point.p_w = T_new_old * point.p_w;
  point.covariance = RotateCovariance(T_new_old.R(), point.covariance);
}
inline void MoveRigidly(const SE3& T_new_old, MapLine& line) {
  const Eigen::Matrix3d R = T_new_old.R();
  line.segment_w = {T_new_old * line.segment_w.p, T_new_old * line.segment_w.q};
  line.covariance_p = RotateCovariance(R, line.covariance_p);
  line.covariance_q = RotateCovariance(R, line.covariance_q);
}

}  // namespace plslam
