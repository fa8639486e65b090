// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <utility>

namespace plslam::vo {

/// Decides whether the features of a frame are followed from the last one (`FeatureTracker`) or detected.
///
/// Features are detected in at least every fourth frame; in each of the first frames and of those after a doubtful one,
/// because a motion must be known, other motions must have shown, and an offset of the disparities is found most easily
/// then; and in frames that become keyframes.
class FollowPolicy {
 public:
  /// Share of the features that must be found; otherwise they are detected. Near features, which show most of a motion, are
  /// lost first.
  static constexpr double kMinShare = 0.6;
  /// Number of features that must be found, lines counted twice: few of them make a pose weak, and detection may find more.
  static constexpr double kMinWeight = 120.0;
  static constexpr int kMostFollowed = 3;
  static constexpr int kSureFrames = 10;

  /// Whether the features of the next frame may be followed.
  bool MayFollow() const {
    return !needs_detection_ && n_sure_ >= kSureFrames && n_followed_ < kMostFollowed && expected_share_ >= kMinShare;
  }
  /// The share of the features that was found in the present frame. As many are expected to be lost in the next one.
  void ObserveShare(double share) {
    expected_share_ = share * std::min(share / share_, 1.0);
    share_ = share;
  }
  /// The features of the next frame must be detected.
  void RequireDetection() { needs_detection_ = true; }

  /// The features of the present frame are followed, or detected; before it is tracked.
  void Follow() {
    ++n_followed_;
    is_followed_ = true;
  }
  void Detect() {
    n_followed_ = 0;
    share_ = expected_share_ = 1.0;
    is_followed_ = false;
    needs_detection_ = false;
  }

  /// Returns whether the features of the frame to be tracked are followed; once for each frame.
  bool TakeIsFollowed() { return std::exchange(is_followed_, false); }
  /// After a frame: whether its pose is beyond doubt.
  void Observe(bool is_sure) { n_sure_ = is_sure ? std::min(n_sure_ + 1, kSureFrames) : 0; }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.n_followed_, self.n_sure_, self.share_, self.expected_share_, self.needs_detection_);
  }

 private:
  int n_followed_ = 0;           ///< since the last frame with detection
  int n_sure_ = 0;               ///< successive frames without doubt
  double share_ = 1.0;           ///< of the features detected last that were found in the last frame
  double expected_share_ = 1.0;  ///< the same in the next frame
  bool needs_detection_ = false;
  bool is_followed_ = false;
};

}  // namespace plslam::vo
