#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace plslam {

/// How many landmarks a keyframe shares with others: a row of the covisibility graph. In one piece of memory, as each sight that comes
/// or goes is counted in many rows.
class SharedCounts {
 public:
  /// The other keyframe and how many (>= 1), ascending by keyframe.
  using Count = std::pair<int64_t, int>;

  void Add(int64_t keyframe_id, int n) {
    const auto place = Place(counts_, keyframe_id);
    if (place == counts_.end() || place->first != keyframe_id) {
      counts_.insert(place, {keyframe_id, n});
    } else if ((place->second += n) == 0) {
      counts_.erase(place);
    }
  }

  int Of(int64_t keyframe_id) const {
    const auto place = Place(counts_, keyframe_id);
    return place == counts_.end() || place->first != keyframe_id ? 0 : place->second;
  }

  std::vector<Count>::const_iterator begin() const { return counts_.begin(); }
  std::vector<Count>::const_iterator end() const { return counts_.end(); }

 private:
  /// Where the count of the keyframe is, or would have to be.
  template <class Counts>
  static auto Place(Counts& counts, int64_t keyframe_id) -> decltype(counts.begin()) {
    return std::lower_bound(counts.begin(), counts.end(), keyframe_id,
                            [](const Count& count, int64_t id) { return count.first < id; });
  }

  std::vector<Count> counts_;
};

}  // namespace plslam
