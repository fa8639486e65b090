#pragma once

#include <cstdint>
#include <optional>

namespace plslam {

/// How long a lockstep stream waits for the map: as long as a mapping_process shows signs of life, and some time more, so
/// that one that is started again is waited for too. Times in s, of any steady clock.
class MapWait {
 public:
  explicit MapWait(double wait_s) : wait_s_(wait_s) {}

  /// mapping_process lives, or says that it ends.
  void OnSignOfLife(double now_s) {
    last_sign_s_ = now_s;
    given_up_ = false;
  }

  /// The map as of this keyframe is needed to go on, unless it was given up before.
  void Begin(int64_t keyframe_id, double now_s) {
    if (given_up_) return;
    keyframe_id_ = keyframe_id;
    began_s_ = now_s;
  }
  void End() { keyframe_id_.reset(); }

  /// Ends a wait that has lasted too long without a sign of life; true if so.
  bool GiveUp(double now_s) {
    if (!keyframe_id_ || now_s - began_s_ < wait_s_ || (last_sign_s_ && now_s - *last_sign_s_ < wait_s_))
      return false;
    given_up_ = true;
    keyframe_id_.reset();
    return true;
  }

  /// The keyframe that is waited for.
  std::optional<int64_t> keyframe_id() const { return keyframe_id_; }

 private:
  double wait_s_;
  std::optional<double> last_sign_s_;
  std::optional<int64_t> keyframe_id_;
  double began_s_ = 0.0;
  bool given_up_ = false;
};

}  // namespace plslam
