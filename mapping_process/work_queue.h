#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/bus/partner_wait.h"
#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "mapping_process/options.h"

namespace plslam {

/// What the owner of the map has to do, in an order that makes results repeatable. No clock and no thread: times are given.
///
/// Of a live stream all keyframes of a session that have come are inserted at once, and what loop_process says is taken over when it
/// comes. Of a lockstep stream each keyframe waits until loop_process has had its say about the one before and that is
/// in the map; where no loop_process is heard of for a while, it goes on without.
///
/// What loop_process said comes again to a process that is started again, and so do the keyframes: about each keyframe it
/// is taken over once that is in the map.
class WorkQueue {
 public:
  struct Arrived {
    Keyframe keyframe;
    double received_ms = 0.0;
  };

  struct Work {
    enum class Kind {
      kInsert,        ///< `keyframes`, and adjust the map
      kCorrect,       ///< by `closure`; afterwards settle if `settles`
      kSettle,        ///< loop_process has nothing to say about the newest keyframe
      kPublishWhole,  ///< somebody lacks the map
      kSave,          ///< the map, to `path`
    };
    Kind kind = Kind::kInsert;
    std::vector<Arrived> keyframes;
    LoopClosure closure;
    bool settles = false;
    std::string path;
  };

  explicit WorkQueue(const LoopUseOptions& options) : options_(options), wait_(options.wait_s) {}

  void Add(const Keyframe& keyframe, double now_ms) { keyframes_.push_back({keyframe, now_ms}); }
  void Add(const LoopClosure& closure);
  void AskForWhole() { asked_ = true; }
  void Save(const std::string& path) { saves_.push_back(path); }

  /// loop_process lives.
  void OnSignOfLife(double now_s) { wait_.OnSignOfLife(now_s); }
  /// Whether a wait for loop_process ended now because it is not heard of.
  bool GiveUp(double now_s) { return wait_.GiveUp(now_s); }

  /// What is to be done next, which then counts as done; nullopt: nothing yet.
  std::optional<Work> Take(double now_s);

  /// The keyframe is in the map now.
  void Inserted(const Keyframe& keyframe, double now_s);

  size_t n_keyframes() const { return keyframes_.size(); }

 private:
  struct Newest {
    int64_t session = 0;
    int64_t keyframe_id = -1;
    bool lockstep = false;
    bool settled = true;
  };

  bool IsInserted(const LoopClosure& closure) const;
  bool IsAboutNewest(const LoopClosure& closure) const;
  std::optional<Work> TakeClosure(double now_s);
  std::vector<Arrived> TakeKeyframes();

  LoopUseOptions options_;
  bus::PartnerWait wait_;
  std::deque<Arrived> keyframes_;
  std::deque<LoopClosure> closures_;
  std::deque<std::string> saves_;
  bool asked_ = false;
  /// Newest keyframe of each session that is in the map.
  std::map<int64_t, int64_t> inserted_;
  Newest newest_;
};

}  // namespace plslam
