// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

namespace plslam::bus {

/// Waiting time of a lockstep stream for the results of another process: as long as that process publishes statuses,
/// and some time more, so that a restart is waited for, too. Times in s, of any steady clock.
class PartnerWait {
 public:
  explicit PartnerWait(double wait_s) : wait_s_(wait_s) {}

  /// The partner is running, or has announced its end.
  void OnSignOfLife(double now_s) {
    last_sign_s_ = now_s;
    given_up_ = false;
  }

  /// Begins to wait for the partner's result for this number, unless the partner was given up before.
  void Begin(int64_t number, double now_s) {
    if (given_up_) return;
    awaited_ = number;
    began_s_ = now_s;
  }
  void End() { awaited_.reset(); }

  /// True once: a wait lasts, and the partner was not heard of.
  bool NoticeSilence(double now_s) {
    static constexpr double kSilence_s = 2.0;
    if (!awaited_ || is_reported_ || now_s - began_s_ < kSilence_s) return false;
    if (last_sign_s_ && now_s - *last_sign_s_ < kSilence_s) return false;
    is_reported_ = wait_s_ > kSilence_s;
    return is_reported_;
  }

  double wait_s() const { return wait_s_; }

  /// Ends a wait that has lasted too long without a sign of life; true if so.
  bool GiveUp(double now_s) {
    if (!awaited_ || now_s - began_s_ < wait_s_ || (last_sign_s_ && now_s - *last_sign_s_ < wait_s_)) return false;
    given_up_ = true;
    awaited_.reset();
    return true;
  }

  /// The number that is waited for.
  std::optional<int64_t> awaited() const { return awaited_; }

 private:
  double wait_s_;
  std::optional<double> last_sign_s_;
  std::optional<int64_t> awaited_;
  double began_s_ = 0.0;
  bool given_up_ = false;
  bool is_reported_ = false;
};

}  // namespace plslam::bus
