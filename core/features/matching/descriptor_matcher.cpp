// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/descriptor_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/features/matching/hamming.h"

namespace plslam {
namespace {

constexpr double kCellSize_px = 24.0;
// Points spread wider than any image get larger cells, not more of them.
constexpr double kMaxCells = 65536.0;
constexpr int kTooFar = 257;  // above any distance of 256 bits
constexpr int kTurnBins = 30;
// Corners nearer to each other than this, in pixels of the coarser octave, are the same corner.
constexpr double kOneCorner_px = 1.5;

// `get` returns the point at an index, nullptr for one to skip.
template <class GetPoint>
std::vector<PointGrid::Entry> MakeEntries(size_t size, const GetPoint& get) {
  std::vector<PointGrid::Entry> entries;
  entries.reserve(size);
  for (size_t i = 0; i < size; ++i) {
    const PointFeature* f = get(i);
    if (f == nullptr || !f->px.allFinite()) continue;
    entries.push_back({{f->px, f->scale}, f->angle_rad, f->octave, static_cast<int>(i), f->descriptor});
  }
  return entries;
}

/// Best and second best.
struct BestTwo {
  int best_distance = kTooFar;
  int second_distance = kTooFar;
  int best_index = -1;

  void Offer(int distance, int index) {
    if (distance < best_distance || (distance == best_distance && index < best_index)) {
      second_distance = best_distance;
      best_distance = distance;
      best_index = index;
    } else if (distance < second_distance) {
      second_distance = distance;
    }
  }

  bool Accepted(const MatchOptions& options) const {
    if (best_index < 0 || best_distance > options.max_distance) return false;
    return options.ratio >= 1.0 || second_distance == kTooFar || best_distance < options.ratio * second_distance;
  }
};

/// A point within the window of a query.
struct PointInWindow {
  int distance = kTooFar;
  const PointGrid::Entry* entry = nullptr;

  bool operator<(const PointInWindow& other) const {
    return distance < other.distance || (distance == other.distance && entry->index < other.entry->index);
  }
};

/// Whether two points are the same corner, detected in neighbouring octaves.
bool AreOneCorner(const CornerPlace& a, const CornerPlace& b) {
  const double apart_px = kOneCorner_px * std::max(a.scale, b.scale);
  return (a.px - b.px).squaredNorm() <= apart_px * apart_px;
}

/// Least distance among `n` points, except those at the best one's corner: another octave of it is no rival.
template <class Distance, class Corner>
int NearestRival(const CornerPlace& best, size_t n, const Distance& distance, const Corner& corner) {
  int nearest = kTooFar;
  for (size_t i = 0; i < n; ++i) {
    if (distance(i) < nearest && !AreOneCorner(corner(i), best)) nearest = distance(i);
  }
  return nearest;
}

/// Returns the match of a query; nullptr if there is none.
const PointInWindow* MatchAmong(const std::vector<PointInWindow>& candidates, const MatchOptions& options) {
  const auto best = std::min_element(candidates.begin(), candidates.end());
  if (best == candidates.end() || best->distance > options.max_distance) return nullptr;
  const int second_distance = NearestRival(
      best->entry->corner, candidates.size(), [&](size_t c) { return candidates[c].distance; },
      [&](size_t c) -> const CornerPlace& { return candidates[c].entry->corner; });
  return BestTwo{best->distance, second_distance, best->entry->index}.Accepted(options) ? &*best : nullptr;
}

int TurnBin(float from_rad, float to_rad) {
  constexpr double kTurn_rad = 2.0 * std::numbers::pi;
  const double turn = (static_cast<double>(to_rad) - static_cast<double>(from_rad)) / kTurn_rad;
  if (!std::isfinite(turn)) return 0;
  return static_cast<int>((turn - std::floor(turn)) * kTurnBins) % kTurnBins;
}

/// Removes matches whose rotation is outside the most frequent bin and its two neighbours.
template <class Turn>
void KeepCommonTurn(std::vector<int>& matches, const Turn& turn_bin) {
  std::array<int, kTurnBins> histogram{};
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] >= 0) ++histogram[turn_bin(static_cast<int>(i), matches[i])];
  }
  // Sums of three neighbouring bins, so that a peak on a bin border is not split.
  int best_bin = 0;
  int best_count = -1;
  for (int b = 0; b < kTurnBins; ++b) {
    const int count = histogram[(b + kTurnBins - 1) % kTurnBins] + histogram[b] + histogram[(b + 1) % kTurnBins];
    if (count > best_count) {
      best_count = count;
      best_bin = b;
    }
  }
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] < 0) continue;
    const int apart = (turn_bin(static_cast<int>(i), matches[i]) - best_bin + kTurnBins) % kTurnBins;
    if (apart > 1 && apart < kTurnBins - 1) matches[i] = -1;
  }
}

/// Keeps for each target only the query nearest to it.
void KeepMutual(std::vector<int>& matches, const std::vector<int>& distances, int target_count) {
  std::vector<int> owner(target_count, -1);
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] < 0) continue;
    int& current = owner[matches[i]];
    if (current < 0 || distances[i] < distances[current]) current = static_cast<int>(i);
  }
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] >= 0 && owner[matches[i]] != static_cast<int>(i)) matches[i] = -1;
  }
}

}  // namespace

PointGrid::PointGrid(const std::vector<PointFeature>& points) {
  Build(MakeEntries(points.size(), [&points](size_t i) { return &points[i]; }), points.size());
}

PointGrid::PointGrid(std::span<const StereoPoint> points) {
  Build(MakeEntries(points.size(), [&points](size_t i) { return &points[i].left; }), points.size());
}

PointGrid::PointGrid(std::span<const StereoPoint> points, const std::vector<char>& eligible) {
  const auto get = [&](size_t i) { return eligible[i] != 0 ? &points[i].left : nullptr; };
  Build(MakeEntries(points.size(), get), points.size());
}

void PointGrid::Build(const std::vector<Entry>& entries, size_t size) {
  size_ = static_cast<int>(size);
  if (entries.empty()) return;
  Eigen::Vector2d last_px = entries.front().corner.px;
  origin_px_ = last_px;
  for (const Entry& e : entries) {
    origin_px_ = origin_px_.cwiseMin(e.corner.px);
    last_px = last_px.cwiseMax(e.corner.px);
  }
  const Eigen::Vector2d extent_px = last_px - origin_px_;
  cell_size_px_ = kCellSize_px;
  while ((extent_px.x() / cell_size_px_ + 1.0) * (extent_px.y() / cell_size_px_ + 1.0) > kMaxCells)
    cell_size_px_ *= 2.0;
  columns_ = static_cast<int>(extent_px.x() / cell_size_px_) + 1;
  rows_ = static_cast<int>(extent_px.y() / cell_size_px_) + 1;
  const auto cell_of = [this](const Entry& e) {
    const Eigen::Vector2i cell = ((e.corner.px - origin_px_) / cell_size_px_).cast<int>();
    return cell.y() * columns_ + cell.x();
  };
  cells_ = Buckets<Entry>(entries, static_cast<size_t>(columns_) * rows_, cell_of);
}

PointGrid::Cells PointGrid::CellsAround(const Eigen::Vector2d& center_px, double radius_px) const {
  if (cells_.size() == 0 || !center_px.allFinite() || !(radius_px >= 0.0)) return {};
  // Clamped before the conversion: predictions may be far outside the range of int.
  const auto cell = [this](double offset_px, int count) {
    return static_cast<int>(std::clamp(std::floor(offset_px / cell_size_px_), -1.0, static_cast<double>(count)));
  };
  const Eigen::Vector2d from = center_px - origin_px_;
  Cells cells;
  cells.x_begin = std::max(cell(from.x() - radius_px, columns_), 0);
  cells.x_end = std::min(cell(from.x() + radius_px, columns_), columns_ - 1) + 1;
  cells.y_begin = std::max(cell(from.y() - radius_px, rows_), 0);
  cells.y_end = std::min(cell(from.y() + radius_px, rows_), rows_ - 1) + 1;
  if (cells.x_begin >= cells.x_end || cells.y_begin >= cells.y_end) return {};
  return cells;
}

std::vector<int> PointGrid::Within(const Eigen::Vector2d& center_px, double radius_px) const {
  std::vector<int> indices;
  ForEachWithin(center_px, radius_px, [&indices](const Entry& e) { indices.push_back(e.index); });
  std::sort(indices.begin(), indices.end());
  return indices;
}

std::vector<int> MatchPointsByProjection(const std::vector<PointQuery>& queries, const PointGrid& grid,
                                         const MatchOptions& options) {
  std::vector<int> matches(queries.size(), -1);
  std::vector<int> distances(queries.size(), kTooFar);
  std::vector<float> angles_rad(grid.size(), 0.0F);
  std::vector<PointInWindow> candidates;
  for (size_t i = 0; i < queries.size(); ++i) {
    const PointQuery& query = queries[i];
    candidates.clear();
    grid.ForEachWithin(query.px, query.radius_px, [&](const PointGrid::Entry& e) {
      if (query.octave >= 0 && std::abs(e.octave - query.octave) > options.octave_window) return;
      candidates.push_back({HammingDistance(query.descriptor, e.descriptor), &e});
    });
    const PointInWindow* best = MatchAmong(candidates, options);
    if (best == nullptr) continue;
    matches[i] = best->entry->index;
    distances[i] = best->distance;
    angles_rad[best->entry->index] = best->entry->angle_rad;
  }
  KeepMutual(matches, distances, grid.size());
  if (options.check_rotation) {
    KeepCommonTurn(matches, [&](int i, int j) { return TurnBin(queries[i].angle_rad, angles_rad[j]); });
  }
  return matches;
}

std::vector<int> MatchBruteForce(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                 const MatchOptions& options, std::span<const CornerPlace> corners_of_b) {
  const int b_count = static_cast<int>(b.size());
  std::vector<int> matches(a.size(), -1);
  std::vector<int> best_of_b(b_count, -1);
  std::vector<uint16_t> best_distance_of_b(b_count, kTooFar);
  std::vector<uint16_t> distances(b_count);
  for (size_t i = 0; i < a.size(); ++i) {
    HammingDistances(a[i], b.data(), b_count, distances.data());
    BestTwo two;
    for (int j = 0; j < b_count; ++j) {
      if (distances[j] < best_distance_of_b[j]) {
        best_distance_of_b[j] = distances[j];
        best_of_b[j] = static_cast<int>(i);
      }
      if (distances[j] < two.second_distance) two.Offer(distances[j], j);
    }
    if (!corners_of_b.empty() && two.best_distance <= options.max_distance && !two.Accepted(options)) {
      two.second_distance = NearestRival(
          corners_of_b[two.best_index], b.size(), [&](size_t j) { return int{distances[j]}; },
          [&](size_t j) -> const CornerPlace& { return corners_of_b[j]; });
    }
    if (two.Accepted(options)) matches[i] = two.best_index;
  }
  for (size_t i = 0; i < a.size(); ++i) {
    if (matches[i] >= 0 && best_of_b[matches[i]] != static_cast<int>(i)) matches[i] = -1;
  }
  return matches;
}

std::vector<int> MatchPointsBruteForce(const std::vector<PointFeature>& a, const std::vector<PointFeature>& b,
                                       const MatchOptions& options) {
  std::vector<int> matches = MatchBruteForce(DescriptorsOf(a), DescriptorsOf(b), options, CornerPlacesOf(b));
  if (options.check_rotation) {
    KeepCommonTurn(matches, [&](int i, int j) { return TurnBin(a[i].angle_rad, b[j].angle_rad); });
  }
  return matches;
}

}  // namespace plslam
