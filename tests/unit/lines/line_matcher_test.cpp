// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/line_matcher.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace plslam {
namespace {

LineFeature Feature(double px, double py, double qx, double qy, uint64_t bits = 0) {
  LineFeature f;
  f.segment = {{px, py}, {qx, qy}};
  f.descriptor[0] = bits;
  return f;
}

PredictedLine Predicted(const LineFeature& f) { return {f.segment, f.descriptor}; }

int MatchOne(const LineFeature& predicted, const LineFeature& feature,
             const LineMatchOptions& options = LineMatchOptions()) {
  return MatchLinesByProjection({Predicted(predicted)}, std::vector<LineFeature>{feature}, options)[0];
}

TEST(MatchLinesByProjection, EachGateRejectsAlone) {
  const LineFeature line = Feature(100, 100, 200, 100);
  EXPECT_EQ(MatchOne(line, Feature(105, 104, 195, 106)), 0);
  EXPECT_EQ(MatchOne(line, Feature(200, 100, 100, 100)), -1) << "polarity";
  EXPECT_EQ(MatchOne(line, Feature(100, 80, 200, 120)), -1) << "direction";
  EXPECT_EQ(MatchOne(line, Feature(100, 125, 200, 125)), -1) << "across";
  EXPECT_EQ(MatchOne(line, Feature(180, 100, 280, 100)), -1) << "overlap";
  EXPECT_EQ(MatchOne(line, Feature(140, 100, 160, 100)), -1) << "length";
  EXPECT_EQ(MatchOne(line, Feature(140, 100, 170, 100)), 0) << "a piece of it will do";
  LineFeature unlike = line;
  unlike.descriptor.fill(0x00ff00ff00ff00ffULL);
  EXPECT_EQ(MatchOne(line, unlike), -1) << "descriptor";
}

TEST(MatchLinesByProjection, AmbiguousParallelLinesGiveNone) {
  const LineFeature line = Feature(100, 100, 200, 100, 0xff);
  const std::vector<LineFeature> two = {Feature(100, 95, 200, 95), Feature(100, 105, 200, 105)};
  EXPECT_EQ(MatchLinesByProjection({Predicted(line)}, two, LineMatchOptions())[0], -1);
  // Two pieces of the same edge are no rivals; one is taken.
  const std::vector<LineFeature> pieces = {Feature(100, 102, 145, 102), Feature(155, 102, 200, 102)};
  EXPECT_GE(MatchLinesByProjection({Predicted(line)}, pieces, LineMatchOptions())[0], 0);
}

TEST(MatchLinesByProjection, NoneOneAndDegenerate) {
  const LineMatchOptions options;
  const std::vector<LineFeature> none;
  EXPECT_TRUE(MatchLinesByProjection({}, none, options).empty());
  const LineFeature line = Feature(1, 2, 30, 40);
  EXPECT_EQ(MatchLinesByProjection({Predicted(line)}, none, options), std::vector<int>{-1});
  EXPECT_TRUE(MatchLinesByProjection({}, std::vector<LineFeature>{line}, options).empty());
  EXPECT_EQ(MatchOne(Feature(NAN, 0, 10, 10), line), -1);
  EXPECT_EQ(MatchOne(line, Feature(5, 5, 5, 5)), -1);
  EXPECT_EQ(MatchOne(line, line), 0);
}

std::vector<LineFeature> RandomLines(size_t count, uint32_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) / 9007199254740992.0;
  };
  std::vector<LineFeature> lines(count);
  for (LineFeature& l : lines) {
    const Eigen::Vector2d p(uniform(0, 300), uniform(0, 200));
    const double angle = uniform(0, 6.28);
    l.segment = {p, p + uniform(20, 90) * Eigen::Vector2d(std::cos(angle), std::sin(angle))};
    // Few different descriptors, so that ratio and mutual test have work.
    l.descriptor = {random() & random() & random(), random() & random() & random(), 0, 0};
  }
  return lines;
}

/// The rules as the header states them, pair by pair.
bool SlowGates(const Segment2& a, const Segment2& b, const LineMatchOptions& o) {
  const Eigen::Vector2d da = (a.q - a.p).normalized();
  const Eigen::Vector2d db = (b.q - b.p).normalized();
  if (std::acos(std::clamp(da.dot(db), -1.0, 1.0)) > o.max_angle_deg * M_PI / 180.0) return false;
  const bool a_longer = a.Length() >= b.Length();
  const Segment2& longer = a_longer ? a : b;
  const Segment2& shorter = a_longer ? b : a;
  const Eigen::Vector3d line = LineThrough(longer);
  const Eigen::Vector2d middle = 0.5 * (shorter.p + shorter.q);
  if (std::abs(line.x() * middle.x() + line.y() * middle.y() + line.z()) > o.max_across_px) return false;
  if (shorter.Length() < o.min_length_ratio * longer.Length()) return false;
  const double s = da.dot(b.p - a.p);
  const double e = da.dot(b.q - a.p);
  return std::min(e, a.Length()) - std::max(s, 0.0) >= o.min_overlap * shorter.Length();
}

std::vector<int> SlowMatch(const std::vector<LineFeature>& a, const std::vector<LineFeature>& b,
                           const LineMatchOptions& o) {
  const auto across = [&](size_t i, size_t j) {
    const Eigen::Vector3d line = LineThrough(a[i].segment);
    const Eigen::Vector2d middle = 0.5 * (b[j].segment.p + b[j].segment.q);
    return line.x() * middle.x() + line.y() * middle.y() + line.z();
  };
  const auto cost = [&](size_t i, size_t j) {
    return HammingDistance(a[i].descriptor, b[j].descriptor) + 1e-6 * std::abs(across(i, j));
  };
  const auto passes = [&](size_t i, size_t j) { return SlowGates(a[i].segment, b[j].segment, o); };
  std::vector<int> match(a.size(), -1);
  for (size_t i = 0; i < a.size(); ++i) {
    int best = -1;
    for (size_t j = 0; j < b.size(); ++j) {
      if (passes(i, j) && (best < 0 || cost(i, j) < cost(i, best))) best = static_cast<int>(j);
    }
    if (best < 0 || cost(i, best) >= o.max_descriptor_distance + 1) continue;
    bool is_best = true;
    for (size_t k = 0; k < a.size(); ++k) is_best &= k == i || !passes(k, best) || cost(k, best) > cost(i, best);
    bool is_clear = true;
    for (size_t j = 0; j < b.size(); ++j) {
      if (!passes(i, j) || std::abs(across(i, j) - across(i, best)) <= 1.5) continue;
      const int rival = HammingDistance(a[i].descriptor, b[j].descriptor);
      is_clear &= HammingDistance(a[i].descriptor, b[best].descriptor) <= o.max_ratio * rival;
    }
    if (is_best && is_clear) match[i] = best;
  }
  return match;
}

TEST(MatchLinesByProjection, AgreesWithTheSlowTwin) {
  LineMatchOptions options;
  options.max_angle_deg = 40.0;
  options.max_across_px = 40.0;
  int matched = 0;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const auto a = RandomLines(60, seed);
    auto b = RandomLines(40, seed + 100);
    for (size_t i = 0; i < 20; ++i) b[i].descriptor = a[i].descriptor;
    std::vector<PredictedLine> predicted;
    for (const LineFeature& l : a) predicted.push_back(Predicted(l));
    const auto fast = MatchLinesByProjection(predicted, b, options);
    EXPECT_EQ(fast, SlowMatch(a, b, options)) << "seed " << seed;
    for (const int m : fast) matched += m >= 0 ? 1 : 0;
  }
  EXPECT_GT(matched, 100);
}

TEST(MatchLinesByProjection, MonoAndStereoLinesMatchAlike) {
  const auto a = RandomLines(120, 7);
  const auto b = RandomLines(120, 7);
  std::vector<PredictedLine> predicted;
  for (const LineFeature& l : a) predicted.push_back(Predicted(l));
  std::vector<StereoLine> stereo(b.size());
  for (size_t i = 0; i < b.size(); ++i) stereo[i].left = b[i];
  const auto match = MatchLinesByProjection(predicted, b, LineMatchOptions());
  EXPECT_EQ(match, MatchLinesByProjection(predicted, stereo, LineMatchOptions()));
  for (size_t i = 0; i < match.size(); ++i) EXPECT_EQ(match[i], static_cast<int>(i));
}

TEST(MatchLinesBruteForce, FindsThePermutation) {
  const auto a = RandomLines(80, 5);
  std::vector<LineFeature> b(a.rbegin(), a.rend());
  for (LineFeature& l : b) l.segment.p += Eigen::Vector2d(1000, 3);
  const auto match = MatchLinesBruteForce(a, b, LineMatchOptions());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(match[i], static_cast<int>(a.size() - 1 - i));
}

TEST(MatchLinesBruteForce, NoneOneAndTwins) {
  const LineMatchOptions options;
  EXPECT_TRUE(MatchLinesBruteForce(std::vector<LineFeature>(), {}, options).empty());
  const LineFeature one = Feature(0, 0, 50, 0, 1);
  EXPECT_EQ(MatchLinesBruteForce({one}, {one}, options), std::vector<int>{0});
  LineFeature near = one;
  near.descriptor[0] = 3;
  LineFeature as_near = one;
  as_near.descriptor[0] = 5;
  EXPECT_EQ(MatchLinesBruteForce({one}, {near, as_near}, options), std::vector<int>{-1}) << "no clear best";
}

}  // namespace
}  // namespace plslam
