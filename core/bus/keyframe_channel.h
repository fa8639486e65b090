#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/bus/bus.h"
#include "core/map/keyframe.h"

namespace plslam {
class keyframe_t;
}

namespace plslam::bus {

/// `keyframe` as pages of at most `page_bytes`, points before lines. Throws std::invalid_argument where the ids are
/// not as many as the features (ids of the map may be left out altogether).
std::vector<keyframe_t> CutIntoPages(const Keyframe& keyframe, int64_t page_bytes);

/// Puts pages together again; they come in order for each publisher.
class KeyframeAssembler {
 public:
  enum class Outcome { kTaken, kComplete, kNonsense };

  /// kComplete: `Take` has the keyframe. kNonsense: a page that cannot be (values, order, or a head that differs from
  /// that of the first page); what had come of the keyframe is dropped.
  Outcome Add(const keyframe_t& page);
  Keyframe Take();

 private:
  struct Partial {
    Keyframe keyframe;
    int32_t next_page = 0;
    int32_t n_pages = 0;
  };

  static std::optional<Keyframe> Head(const keyframe_t& page);
  static bool Append(const keyframe_t& page, Keyframe& keyframe);

  std::map<int64_t, Partial> partials_;  // by publisher
  std::optional<Keyframe> complete_;
};

/// Sends keyframes; `header_t.session` and `t_ns` are taken from the keyframe.
class KeyframePublisher {
 public:
  explicit KeyframePublisher(Bus& bus) : bus_(bus) {}
  void Publish(const Keyframe& keyframe);

 private:
  Bus& bus_;
};

/// Hands every keyframe of every publisher to `handler`, in order, on the thread of `Bus::Run`. Pages that cannot be
/// are counted in `BusCounters::rejected`.
class KeyframeSubscriber {
 public:
  KeyframeSubscriber(Bus& bus, std::function<void(const Keyframe&)> handler);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace plslam::bus
