// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_select.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "core/features/matching/buckets.h"

namespace plslam {
namespace {

constexpr int kBins = 128;
/// Sine of the largest angle (5 degrees) between pieces of one edge.
constexpr double kMaxSine = 0.087;
constexpr double kMaxOffset_px = 1.2;
constexpr double kMaxGap_px = 8.0;
/// A gap between long pieces may be longer, as a share of the shorter one.
constexpr double kMaxGapShare = 0.3;
constexpr double kMaxGapLong_px = 20.0;
/// Largest distance of parallel segments, over most of the shorter one, that are one edge detected twice.
constexpr double kDuplicate_px = 1.5;

/// A segment with its precomputed length and unit direction.
struct Piece {
  DetectedSegment segment;
  double length = 0.0;
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
  bool alive = true;
};

/// Index of a direction on a circle of `kBins`; monotonic in the angle, without trigonometry, so that it is the same on
/// every machine.
int DirectionBin(const Eigen::Vector2d& d) {
  const double x = d.x();
  const double y = d.y();
  const double t = y / (std::abs(x) + std::abs(y));
  const double turn = x >= 0 ? (y >= 0 ? t : 4.0 + t) : 2.0 - t;
  return static_cast<int>(0.25 * turn * kBins) % kBins;
}

Piece MakePiece(const DetectedSegment& segment) {
  const Eigen::Vector2d step = segment.segment.q - segment.segment.p;
  const double length = step.norm();
  return {segment, length, step / length, true};
}

enum class Relation { kApart, kDuplicate, kSameEdge };

/// Returns the relation of the shorter segment `b` to `a`.
Relation Relate(const Piece& a, const Piece& b) {
  const Eigen::Vector2d normal(-a.direction.y(), a.direction.x());
  const double sp = normal.dot(b.segment.segment.p - a.segment.segment.p);
  const double sq = normal.dot(b.segment.segment.q - a.segment.segment.p);
  if (std::abs(sp + sq) > 2.0 * kDuplicate_px) return Relation::kApart;
  if (std::abs(sp - sq) > kMaxSine * b.length || a.direction.dot(b.direction) <= 0.0) return Relation::kApart;
  const double tp = a.direction.dot(b.segment.segment.p - a.segment.segment.p);
  const double tq = a.direction.dot(b.segment.segment.q - a.segment.segment.p);
  const double overlap = std::min(tq, a.length) - std::max(tp, 0.0);
  if (overlap > 0.5 * b.length) return Relation::kDuplicate;
  const double allowed = std::clamp(kMaxGapShare * b.length, kMaxGap_px, kMaxGapLong_px);
  return -overlap <= allowed ? Relation::kSameEdge : Relation::kApart;
}

/// Scatter of points spread evenly along segments.
struct Scatter {
  double mass = 0.0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();

  void Add(const Piece& piece, const Eigen::Vector2d& origin) {
    const Eigen::Vector2d middle = 0.5 * (piece.segment.segment.p + piece.segment.segment.q) - origin;
    mass += piece.length;
    first += piece.length * middle;
    second += piece.length * (middle * middle.transpose()) +
              piece.length * piece.length * piece.length / 12.0 * (piece.direction * piece.direction.transpose());
  }
};

/// Unit eigenvector of the larger eigenvalue of [xx xy; xy yy], directed like `like`.
Eigen::Vector2d MainAxis(const Eigen::Matrix2d& m, const Eigen::Vector2d& like) {
  const double half = 0.5 * (m(0, 0) - m(1, 1));
  const double root = std::sqrt(half * half + m(0, 1) * m(0, 1));
  Eigen::Vector2d axis = half >= 0.0 ? Eigen::Vector2d(half + root, m(0, 1)) : Eigen::Vector2d(m(0, 1), root - half);
  const double norm = axis.norm();
  if (!(norm > 0.0)) return like;
  axis /= norm;
  return axis.dot(like) >= 0.0 ? axis : Eigen::Vector2d(-axis);
}

/// Returns the segment through both pieces, unless an end of either is too far from it.
std::optional<Piece> Join(const Piece& a, const Piece& b) {
  const Eigen::Vector2d origin = a.segment.segment.p;
  Scatter scatter;
  scatter.Add(a, origin);
  scatter.Add(b, origin);
  const Eigen::Vector2d mean = scatter.first / scatter.mass;
  const Eigen::Matrix2d spread = scatter.second / scatter.mass - mean * mean.transpose();
  const Eigen::Vector2d axis = MainAxis(spread, a.direction);
  const Eigen::Vector2d normal(-axis.y(), axis.x());
  double low = 0.0;
  double high = 0.0;
  for (const Eigen::Vector2d& end :
       {a.segment.segment.p, a.segment.segment.q, b.segment.segment.p, b.segment.segment.q}) {
    const Eigen::Vector2d from_mean = end - origin - mean;
    if (std::abs(normal.dot(from_mean)) > kMaxOffset_px) return std::nullopt;
    low = std::min(low, axis.dot(from_mean));
    high = std::max(high, axis.dot(from_mean));
  }
  DetectedSegment joined;
  joined.segment = {origin + mean + low * axis, origin + mean + high * axis};
  joined.contrast = (a.segment.contrast * a.length + b.segment.contrast * b.length) / (a.length + b.length);
  return MakePiece(joined);
}

/// Pieces grouped by direction, so that each is compared only with nearly parallel ones.
class Merger {
 public:
  explicit Merger(const std::vector<DetectedSegment>& segments) {
    pieces_.reserve(segments.size());
    for (const DetectedSegment& s : segments) {
      const Piece piece = MakePiece(s);
      if (!(piece.length > 0.0) || !piece.direction.allFinite()) continue;
      pieces_.push_back(piece);
    }
    bins_ = IndicesByBucket(pieces_.size(), kBins,
                            [this](int i) { return DirectionBin(pieces_[static_cast<size_t>(i)].direction); });
  }

  std::vector<DetectedSegment> Merge() {
    for (size_t i = 0; i < pieces_.size(); ++i) {
      while (pieces_[i].alive && Absorb(i)) {
      }
    }
    std::vector<DetectedSegment> merged;
    for (const Piece& piece : pieces_) {
      if (piece.alive) merged.push_back(piece.segment);
    }
    return merged;
  }

 private:
  /// Joins the pieces that belong to piece i; returns whether it grew, so that more may belong to it.
  bool Absorb(size_t i) {
    bool grew = false;
    const int middle = DirectionBin(pieces_[i].direction);
    for (int offset = -2; offset <= 2; ++offset) {
      const auto bin = static_cast<size_t>((middle + offset + kBins) % kBins);
      for (const int place : bins_.Range(bin, bin + 1)) {
        const auto j = static_cast<size_t>(place);
        if (j != i && pieces_[j].alive && pieces_[j].length <= pieces_[i].length) grew |= TakeIn(i, j);
      }
    }
    return grew;
  }

  bool TakeIn(size_t i, size_t j) {
    const Relation relation = Relate(pieces_[i], pieces_[j]);
    if (relation == Relation::kApart) return false;
    if (relation == Relation::kDuplicate) {
      pieces_[j].alive = false;
      return false;
    }
    const std::optional<Piece> joined = Join(pieces_[i], pieces_[j]);
    if (!joined) return false;
    pieces_[i] = *joined;
    pieces_[j].alive = false;
    return true;
  }

  std::vector<Piece> pieces_;
  /// Indices of pieces by their initial direction.
  Buckets<int> bins_;
};

constexpr int kCellColumns = 8;
constexpr int kCellRows = 5;

int Cell(const Segment2& segment, cv::Size size) {
  const Eigen::Vector2d middle = 0.5 * (segment.p + segment.q);
  const int column = std::clamp(static_cast<int>(middle.x() * kCellColumns / size.width), 0, kCellColumns - 1);
  const int row = std::clamp(static_cast<int>(middle.y() * kCellRows / size.height), 0, kCellRows - 1);
  return row * kCellColumns + column;
}

}  // namespace

std::vector<DetectedSegment> LongestFirst(const std::vector<DetectedSegment>& segments) {
  // Sorts lengths and indices, because comparing segments needs square roots, and swapping them copies more.
  std::vector<std::pair<double, size_t>> order;
  order.reserve(segments.size());
  for (size_t i = 0; i < segments.size(); ++i) order.emplace_back(segments[i].segment.Length(), i);
  const auto place = [&](size_t i) {
    const Segment2& s = segments[i].segment;
    return std::make_tuple(s.p.y(), s.p.x(), s.q.y(), s.q.x(), i);
  };
  std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : place(a.second) < place(b.second);
  });
  std::vector<DetectedSegment> sorted;
  sorted.reserve(segments.size());
  for (const auto& [length, i] : order) sorted.push_back(segments[i]);
  return sorted;
}

std::vector<DetectedSegment> MergeCollinear(const std::vector<DetectedSegment>& segments) {
  return LongestFirst(Merger(LongestFirst(segments)).Merge());
}

std::vector<DetectedSegment> SelectSpread(const std::vector<DetectedSegment>& segments, cv::Size image_size,
                                          int max_lines) {
  if (static_cast<int>(segments.size()) <= max_lines) return segments;
  const double share = std::max(1.0, max_lines / static_cast<double>(kCellColumns * kCellRows));
  std::array<int, kCellColumns * kCellRows> in_cell{};
  std::vector<std::pair<double, size_t>> ranked;
  ranked.reserve(segments.size());
  for (size_t i = 0; i < segments.size(); ++i) {
    int& before = in_cell[static_cast<size_t>(Cell(segments[i].segment, image_size))];
    ranked.emplace_back(-segments[i].segment.Length() / (1.0 + before / share), i);
    ++before;
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<DetectedSegment> kept;
  kept.reserve(static_cast<size_t>(max_lines));
  for (size_t k = 0; k < static_cast<size_t>(max_lines); ++k) kept.push_back(segments[ranked[k].second]);
  return kept;
}

}  // namespace plslam
