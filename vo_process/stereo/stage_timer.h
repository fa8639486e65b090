// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace plslam::vo {

/// Wall time of one stage of a frame.
struct StageTime {
  std::string name;
  double ms = 0.0;
};

/// Measures stages with a clock that is passed in, so that algorithms need none.
class StageTimer {
 public:
  /// `now_ms` increases; without a clock all times are zero.
  explicit StageTimer(std::function<double()> now_ms = nullptr) : now_ms_(std::move(now_ms)) {}

  /// Runs `f` as stage `name`, and returns what it returns.
  template <class F>
  auto Time(const std::string& name, const F& f) {
    const Scope scope(*this, name);
    return f();
  }

  const std::vector<StageTime>& stages() const { return stages_; }

 private:
  struct Scope {
    Scope(StageTimer& t, const std::string& n) : timer(t), name(n), begin_ms(t.Now()) {}
    ~Scope() { timer.stages_.push_back({name, timer.Now() - begin_ms}); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;
    StageTimer& timer;
    std::string name;
    double begin_ms;
  };

  double Now() const { return now_ms_ ? now_ms_() : 0.0; }

  std::function<double()> now_ms_;
  std::vector<StageTime> stages_;
};

}  // namespace plslam::vo
