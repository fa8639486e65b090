// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/se3.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// Differential entropy h = 3 (1 + log 2 pi) + 0.5 log |cov| of a motion (PL-SLAM §IV.D), in nats. From eigenvalues,
/// so determinants far below the smallest double are fine. nullopt for a covariance that is not finite or not
/// positive definite.
std::optional<double> MotionEntropy(const Matrix6d& covariance);

/// The paper's ratio alpha = h(now) / h(first) that falls below a threshold (0.9) when a new keyframe is due.
///
/// It is meant for entropies below zero, as covariances of millimetres and milliradians have: more uncertainty moves
/// h(now) towards zero and alpha below 1. Where h(first) is not clearly negative the quotient loses this meaning (it
/// jumps, or grows with uncertainty), so there alpha = 1 - (h(now) - h(first)) / kReference instead, which has the
/// same sign and a comparable slope; kReference is the entropy's usual size, 30 nats. Always: 1 at equal uncertainty,
/// smaller for more, larger for less. nullopt where either entropy is.
std::optional<double> EntropyRatio(const Matrix6d& covariance_first, const Matrix6d& covariance_now);

/// Why a frame becomes a keyframe.
enum class KeyframeReason { kNone, kFirst, kEntropy, kTracked, kBaseline, kRotation, kAge };

/// A tracked frame as the choice of keyframes sees it.
struct KeyframeCandidate {
  /// Motion since the last keyframe, and the covariance of its right perturbation.
  SE3 T_kf_c;
  Matrix6d covariance = Matrix6d::Zero();
  /// Landmarks that the last keyframe knew and this frame sees (points + 2 x lines).
  int tracked_from_keyframe = 0;
  /// Median depth of what is tracked.
  double median_depth_m = 0.0;
  /// Share of what is tracked that many keyframes of the map see already (`KeyframeOptions::known_observations`).
  double known_share = 0.0;
};

struct KeyframeDecision {
  KeyframeReason reason = KeyframeReason::kNone;
  /// alpha of PL-SLAM §IV.D: h(kf -> now) / h(kf -> kf + 1), with negative entropies as usual for small covariances;
  /// 1 for the first frame after a keyframe, falling as uncertainty grows. 0 where undefined.
  double entropy_ratio = 0.0;
};

/// Choice of keyframes by entropy ratio (PL-SLAM §IV.D), with floors on what is tracked, on motion and on age. A
/// standing camera makes none, however long it stands.
class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeOptions& options) : options_(options) {}

  /// To be called for each tracked frame after a keyframe, in order.
  KeyframeDecision Decide(const KeyframeCandidate& candidate);

  /// Starts anew after a keyframe.
  void Restart();

  /// All that it goes on with, for `core/io/files/archive.h`.
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
