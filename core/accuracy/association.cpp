// SPDX-License-Identifier: BSD-3-Clause
#include "core/accuracy/association.h"

#include <algorithm>
#include <queue>
#include <tuple>

namespace plslam {
namespace {

// Both trajectories merged by time into one doubly linked list. The closest remaining pair consists of neighbours in
// it, so a heap of neighbours finds all pairs in n log n.
class MergedTimes {
 public:
  MergedTimes(const Trajectory& estimate, const Trajectory& truth) {
    entries_.reserve(estimate.size() + truth.size());
    for (size_t i = 0; i < estimate.size(); ++i) entries_.push_back({estimate[i].t_ns, true, i});
    for (size_t i = 0; i < truth.size(); ++i) entries_.push_back({truth[i].t_ns, false, i});
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
      return std::tie(a.t_ns, a.is_estimate, a.index) < std::tie(b.t_ns, b.is_estimate, b.index);
    });
    const int n = static_cast<int>(entries_.size());
    for (int i = 0; i < n; ++i) {
      entries_[i].previous = i - 1;
      entries_[i].next = i + 1 < n ? i + 1 : -1;
      Push(i, entries_[i].next);
    }
  }

  /// Removes the closest remaining pair and returns its indices; returns false if none is within the bound.
  bool TakeClosest(uint64_t max_difference_ns, size_t& estimate, size_t& truth) {
    while (!heap_.empty() && heap_.top().difference_ns <= max_difference_ns) {
      const Neighbours pair = heap_.top();
      heap_.pop();
      if (entries_[pair.a].taken || entries_[pair.b].taken) continue;
      estimate = pair.estimate;
      truth = pair.truth;
      Unlink(pair.a, pair.b);
      return true;
    }
    return false;
  }

 private:
  struct Entry {
    int64_t t_ns;
    bool is_estimate;
    size_t index;
    int previous = -1;
    int next = -1;
    bool taken = false;
  };
  struct Neighbours {
    uint64_t difference_ns;
    size_t estimate;
    size_t truth;
    int a;
    int b;
    bool operator>(const Neighbours& o) const {
      return std::tie(difference_ns, estimate, truth) > std::tie(o.difference_ns, o.estimate, o.truth);
    }
  };

  void Push(int a, int b) {
    if (a < 0 || b < 0 || entries_[a].is_estimate == entries_[b].is_estimate) return;
    const Entry& estimate = entries_[a].is_estimate ? entries_[a] : entries_[b];
    const Entry& truth = entries_[a].is_estimate ? entries_[b] : entries_[a];
    // Unsigned, because the difference of two extreme times exceeds 63 bits.
    const uint64_t difference = static_cast<uint64_t>(entries_[b].t_ns) - static_cast<uint64_t>(entries_[a].t_ns);
    heap_.push({difference, estimate.index, truth.index, a, b});
  }

  void Unlink(int a, int b) {
    entries_[a].taken = entries_[b].taken = true;
    const int before = entries_[a].previous;
    const int after = entries_[b].next;
    if (before >= 0) entries_[before].next = after;
    if (after >= 0) entries_[after].previous = before;
    Push(before, after);
  }

  std::vector<Entry> entries_;
  std::priority_queue<Neighbours, std::vector<Neighbours>, std::greater<>> heap_;
};

SE3 Interpolate(const SE3& a, const SE3& b, double share) {
  return {a.rotation().slerp(share, b.rotation()), (1.0 - share) * a.translation() + share * b.translation()};
}

}  // namespace

SE3 MotionError(const PosePair& i, const PosePair& j) {
  return (i.truth.Inverse() * j.truth).Inverse() * (i.estimate.Inverse() * j.estimate);
}

PosePairs AssociateNearest(const Trajectory& estimate, const Trajectory& truth, int64_t max_difference_ns) {
  PosePairs pairs;
  if (max_difference_ns < 0) return pairs;
  MergedTimes times(estimate, truth);
  size_t e = 0;
  size_t t = 0;
  while (times.TakeClosest(static_cast<uint64_t>(max_difference_ns), e, t)) {
    pairs.push_back({estimate[e].t_ns, estimate[e].T_a_b, truth[t].T_a_b, static_cast<int>(e)});
  }
  std::sort(pairs.begin(), pairs.end(), [](const PosePair& a, const PosePair& b) { return a.t_ns < b.t_ns; });
  return pairs;
}

PosePairs AssociateInterpolated(const Trajectory& estimate, const Trajectory& truth, int64_t max_gap_ns) {
  PosePairs pairs;
  for (size_t i = 0; i < estimate.size(); ++i) {
    const int64_t t_ns = estimate[i].t_ns;
    const auto after = std::lower_bound(truth.begin(), truth.end(), t_ns,
                                        [](const TrajectoryPose& pose, int64_t t) { return pose.t_ns < t; });
    if (after == truth.end()) break;
    if (after->t_ns == t_ns) {
      pairs.push_back({t_ns, estimate[i].T_a_b, after->T_a_b, static_cast<int>(i)});
      continue;
    }
    if (after == truth.begin()) continue;
    const auto before = after - 1;
    const double gap_ns = static_cast<double>(after->t_ns) - static_cast<double>(before->t_ns);
    if (gap_ns > static_cast<double>(max_gap_ns)) continue;
    const double share = static_cast<double>(t_ns - before->t_ns) / static_cast<double>(after->t_ns - before->t_ns);
    pairs.push_back({t_ns, estimate[i].T_a_b, Interpolate(before->T_a_b, after->T_a_b, share), static_cast<int>(i)});
  }
  return pairs;
}

}  // namespace plslam
