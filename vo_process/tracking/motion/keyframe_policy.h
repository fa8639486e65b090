// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/se3.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// Returns the differential entropy h = 3 (1 + log 2 pi) + 0.5 log |cov| of a motion (PL-SLAM §IV.D), in nats.
/// Computed from eigenvalues, so determinants far below the smallest double are fine. Returns nullopt for a covariance
/// that is not finite or not positive definite.
std::optional<double> MotionEntropy(const Matrix6d& covariance);

/// Returns the paper's ratio alpha = h(now) / h(first), which falls below a threshold (0.9) when a keyframe is due.
///
/// It is meant for negative entropies, as covariances of millimetres and milliradians have: more uncertainty moves
/// h(now) towards zero and alpha below 1. If h(first) is not clearly negative, the quotient loses this meaning (it
/// jumps, or grows with uncertainty), and alpha = 1 - (h(now) - h(first)) / kReference instead, which has the same sign
/// and a comparable slope; kReference is the usual magnitude of the entropy, 30 nats. Always 1 at equal uncertainty,
/// smaller for more, larger for less. Returns nullopt if either entropy is undefined.
std::optional<double> EntropyRatio(const Matrix6d& covariance_first, const Matrix6d& covariance_now);

/// Reason why a frame becomes a keyframe.
enum class KeyframeReason { kNone, kFirst, kEntropy, kTracked, kBaseline, kRotation, kAge };

/// A tracked frame, as input to the choice of keyframes.
struct KeyframeCandidate {
  /// Motion since the last keyframe, and the covariance of its right perturbation.
  SE3 T_kf_c;
  Matrix6d covariance = Matrix6d::Zero();
  /// Landmarks known to the last keyframe and tracked in this frame (points + 2 x lines).
  int tracked_from_keyframe = 0;
  /// Median depth of the tracked landmarks.
  double median_depth_m = 0.0;
  /// Share of the tracked landmarks that many keyframes of the map observe (`KeyframeOptions::known_observations`).
  double known_share = 0.0;
};

struct KeyframeDecision {
  KeyframeReason reason = KeyframeReason::kNone;
  /// The ratio alpha of PL-SLAM §IV.D: h(kf -> now) / h(kf -> kf + 1), with negative entropies if covariances are small;
  /// 1 for the first frame after a keyframe, falling as uncertainty grows. 0 where undefined.
  double entropy_ratio = 0.0;
};

/// Choice of keyframes by entropy ratio (PL-SLAM §IV.D), with limits on tracked landmarks, motion and age. A standing
/// camera makes none, however long it stands.
class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeOptions& options) : options_(options) {}

  /// Call this for each tracked frame after a keyframe, in order.
  KeyframeDecision Decide(const KeyframeCandidate& candidate);

  /// Restarts after a keyframe.
  void Restart();

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.frames_, self.first_covariance_, self.first_tracked_);
  }

 private:
  KeyframeOptions options_;
  int frames_ = 0;
  Matrix6d first_covariance_ = Matrix6d::Identity();
  int first_tracked_ = 0;
};

}  // namespace plslam::vo
