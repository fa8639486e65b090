// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/line_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/features/matching/hamming.h"

namespace plslam {
namespace {

/// A segment with the values that the gates need.
struct Directed {
  Eigen::Vector2d p, q, direction, normal;
  double length = 0.0;
  bool valid = false;
};

Directed MakeDirected(const Segment2& s) {
  Directed d;
  d.p = s.p;
  d.q = s.q;
  d.length = s.Length();
  d.valid = s.p.allFinite() && s.q.allFinite() && d.length >= 1.0;
  if (!d.valid) return d;
  d.direction = (s.q - s.p) / d.length;
  d.normal = {-d.direction.y(), d.direction.x()};
  return d;
}

/// Signed distance of the midpoint of b from the line of a.
double Across(const Directed& a, const Directed& b) { return a.normal.dot(0.5 * (b.p + b.q) - a.p); }

/// Length of the part of a's line that both cover.
double Overlap(const Directed& a, const Directed& b) {
  const double tp = a.direction.dot(b.p - a.p);
  const double tq = a.direction.dot(b.q - a.p);
  return std::min(a.length, std::max(tp, tq)) - std::max(0.0, std::min(tp, tq));
}

class MatchGates {
 public:
  explicit MatchGates(const LineMatchOptions& o)
      : options_(o), min_cosine_(std::cos(std::min(o.max_angle_deg, 90.0) * M_PI / 180.0)) {}

  bool Pass(const Directed& a, const Directed& b) const {
    if (a.direction.dot(b.direction) < min_cosine_) return false;
    // Distance of the shorter one's midpoint from the longer line, whose direction is more accurate.
    const double across = a.length >= b.length ? Across(a, b) : Across(b, a);
    if (std::abs(across) > options_.max_across_px) return false;
    const double shorter = std::min(a.length, b.length);
    const double longer = std::max(a.length, b.length);
    return shorter >= options_.min_length_ratio * longer && Overlap(a, b) >= options_.min_overlap * shorter;
  }

 private:
  const LineMatchOptions& options_;
  double min_cosine_;
};

struct Candidate {
  size_t a;
  size_t b;
  int distance;
  /// Distance of the feature's midpoint from the predicted line; equal distances belong to pieces of one edge.
  double across;
};

constexpr int kNoRival = 257;
constexpr double kSamePlace_px = 1.5;

struct BestMatch {
  const Candidate* candidate = nullptr;
  int rival_distance = kNoRival;
};

std::vector<BestMatch> BestOf(const std::vector<Candidate>& candidates, size_t count, size_t Candidate::*side) {
  std::vector<BestMatch> best(count);
  const auto nearer = [](const Candidate& x, const Candidate& y) {
    return x.distance != y.distance ? x.distance < y.distance : std::abs(x.across) < std::abs(y.across);
  };
  for (const Candidate& c : candidates) {
    BestMatch& b = best[c.*side];
    if (b.candidate == nullptr || nearer(c, *b.candidate)) b.candidate = &c;
  }
  for (const Candidate& c : candidates) {
    BestMatch& b = best[c.*side];
    if (&c == b.candidate || std::abs(c.across - b.candidate->across) <= kSamePlace_px) continue;
    b.rival_distance = std::min(b.rival_distance, c.distance);
  }
  return best;
}

std::vector<int> Choose(const std::vector<Candidate>& candidates, size_t count_a, size_t count_b,
                        const LineMatchOptions& options) {
  std::vector<int> match(count_a, -1);
  const std::vector<BestMatch> of_a = BestOf(candidates, count_a, &Candidate::a);
  const std::vector<BestMatch> of_b = BestOf(candidates, count_b, &Candidate::b);
  for (size_t i = 0; i < count_a; ++i) {
    const Candidate* c = of_a[i].candidate;
    if (c == nullptr || of_b[c->b].candidate != c || c->distance > options.max_descriptor_distance) continue;
    if (c->distance <= options.max_ratio * of_a[i].rival_distance) match[i] = static_cast<int>(c->b);
  }
  return match;
}

const LineFeature& FeatureOf(const LineFeature& f) { return f; }
const LineFeature& FeatureOf(const StereoLine& f) { return f.left; }

template <class Feature>
std::vector<int> MatchByProjection(const std::vector<PredictedLine>& predicted, const std::vector<Feature>& features,
                                   const LineMatchOptions& options) {
  std::vector<Directed> found;
  found.reserve(features.size());
  for (const Feature& f : features) found.push_back(MakeDirected(FeatureOf(f).segment));
  const MatchGates gates(options);
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < predicted.size(); ++i) {
    const Directed a = MakeDirected(predicted[i].segment);
    if (!a.valid) continue;
    for (size_t j = 0; j < found.size(); ++j) {
      if (!found[j].valid || !gates.Pass(a, found[j])) continue;
      candidates.push_back(
          {i, j, HammingDistance(predicted[i].descriptor, FeatureOf(features[j]).descriptor), Across(a, found[j])});
    }
  }
  return Choose(candidates, predicted.size(), features.size(), options);
}

}  // namespace

std::vector<int> MatchLinesByProjection(const std::vector<PredictedLine>& predicted,
                                        const std::vector<LineFeature>& features, const LineMatchOptions& options) {
  return MatchByProjection(predicted, features, options);
}

std::vector<int> MatchLinesByProjection(const std::vector<PredictedLine>& predicted,
                                        const std::vector<StereoLine>& features, const LineMatchOptions& options) {
  return MatchByProjection(predicted, features, options);
}

std::vector<int> MatchLinesBruteForce(const std::vector<LineFeature>& a, const std::vector<LineFeature>& b,
                                      const LineMatchOptions& options) {
  return MatchLinesBruteForce(DescriptorsOf(a), DescriptorsOf(b), options);
}

std::vector<int> MatchLinesBruteForce(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                      const LineMatchOptions& options) {
  std::vector<Candidate> candidates;
  candidates.reserve(a.size() * b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t j = 0; j < b.size(); ++j) {
      // Distinct distances make every other line a rival.
      candidates.push_back({i, j, HammingDistance(a[i], b[j]), 1e3 * static_cast<double>(j)});
    }
  }
  return Choose(candidates, a.size(), b.size(), options);
}

}  // namespace plslam
