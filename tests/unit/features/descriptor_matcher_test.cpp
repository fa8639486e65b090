// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/descriptor_matcher.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace plslam {
namespace {

Descriptor RandomDescriptor(std::mt19937_64& random) { return {random(), random(), random(), random()}; }

Descriptor Flipped(Descriptor d, int bits, std::mt19937_64& random) {
  for (int i = 0; i < bits; ++i) d[random() % 4] ^= 1ULL << (random() % 64);
  return d;
}

std::vector<PointFeature> RandomPoints(int count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(0.0, 640.0);
  std::vector<PointFeature> points(count);
  for (PointFeature& p : points) {
    p.px = {u(random), 0.7 * u(random)};
    p.octave = static_cast<int>(random() % 4);
    p.descriptor = RandomDescriptor(random);
  }
  return points;
}

/// The same points seen again: shuffled by a stride, moved a little, some bits flipped.
std::vector<PointFeature> SeenAgain(const std::vector<PointFeature>& points, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, 1.5);
  std::vector<PointFeature> again(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    PointFeature& p = again[(i * 7 + 3) % points.size()];
    p = points[i];
    p.px += Eigen::Vector2d{noise(random), noise(random)};
    p.descriptor = Flipped(p.descriptor, 12, random);
  }
  return again;
}

std::vector<PointQuery> QueriesFor(const std::vector<PointFeature>& points, double radius_px) {
  std::vector<PointQuery> queries;
  for (const PointFeature& p : points) queries.push_back({p.px, radius_px, p.octave, p.angle_rad, p.descriptor});
  return queries;
}

/// By the definition, one pair after the other.
std::vector<int> NaiveMatches(const std::vector<PointQuery>& queries, const std::vector<PointFeature>& points,
                              const MatchOptions& options) {
  struct Best {
    int index = -1, distance = 1000, second = 1000;
  };
  std::vector<Best> best(queries.size());
  const auto for_each_near = [&](const PointQuery& query, const auto& visit) {
    for (size_t j = 0; j < points.size(); ++j) {
      if ((query.px - points[j].px).norm() > query.radius_px) continue;
      if (query.octave >= 0 && std::abs(query.octave - points[j].octave) > options.octave_window) continue;
      visit(j, HammingDistance(query.descriptor, points[j].descriptor));
    }
  };
  for (size_t i = 0; i < queries.size(); ++i) {
    for_each_near(queries[i], [&](size_t j, int d) {
      if (d < best[i].distance) best[i] = {static_cast<int>(j), d, 1000};
    });
    for_each_near(queries[i], [&](size_t j, int d) {
      const PointFeature& winner = points[static_cast<size_t>(best[i].index)];
      const double apart_px = (points[j].px - winner.px).norm();
      if (apart_px > 1.5 * std::max(points[j].scale, winner.scale)) best[i].second = std::min(best[i].second, d);
    });
    const bool clear =
        best[i].second == 1000 || options.ratio >= 1.0 || best[i].distance < options.ratio * best[i].second;
    if (best[i].distance > options.max_distance || !clear) best[i].index = -1;
  }
  std::vector<int> matches(queries.size(), -1);
  for (size_t i = 0; i < queries.size(); ++i) {
    bool mine = best[i].index >= 0;
    for (size_t k = 0; k < queries.size() && mine; ++k) {
      if (k == i || best[k].index != best[i].index) continue;
      mine = best[i].distance < best[k].distance || (best[i].distance == best[k].distance && i < k);
    }
    if (mine) matches[i] = best[i].index;
  }
  return matches;
}

TEST(PointGrid, WithinEqualsTestingEveryPoint) {
  std::mt19937_64 random(1);
  const std::vector<PointFeature> points = RandomPoints(300, random);
  const PointGrid grid(points);
  for (const double radius : {0.0, 3.0, 24.0, 80.0, 2000.0}) {
    for (const Eigen::Vector2d& center : {Eigen::Vector2d(300, 200), Eigen::Vector2d(0, 0), Eigen::Vector2d(700, 500),
                                          Eigen::Vector2d(-50, 100), Eigen::Vector2d(1e18, -1e18), points[5].px}) {
      std::vector<int> expected;
      for (size_t i = 0; i < points.size(); ++i) {
        if ((points[i].px - center).norm() <= radius) expected.push_back(static_cast<int>(i));
      }
      EXPECT_EQ(grid.Within(center, radius), expected) << center.transpose() << " radius " << radius;
    }
  }
}

TEST(PointGrid, EmptyAndNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(PointGrid().Within({1, 1}, 10).empty());
  EXPECT_TRUE(PointGrid(std::vector<PointFeature>{}).Within({1, 1}, 10).empty());
  std::vector<PointFeature> points(3);
  points[1].px = {nan, 5.0};
  const PointGrid grid(points);
  EXPECT_EQ(grid.Within({0, 0}, 1), (std::vector<int>{0, 2}));
  EXPECT_TRUE(grid.Within({nan, 0}, 1).empty());
  EXPECT_TRUE(grid.Within({0, 0}, nan).empty());
  EXPECT_TRUE(grid.Within({0, 0}, -1).empty());
}

TEST(MatchPointsByProjection, EqualsTheDefinition) {
  std::mt19937_64 random(2);
  const std::vector<PointFeature> points = RandomPoints(400, random);
  const std::vector<PointFeature> again = SeenAgain(points, random);
  for (const double ratio : {0.5, 0.9, 1.0}) {
    MatchOptions options;
    options.ratio = ratio;
    options.max_distance = 110;  // wrong matches too, so that every rule is used
    const std::vector<PointQuery> queries = QueriesFor(points, 60.0);
    EXPECT_EQ(MatchPointsByProjection(queries, PointGrid(again), options), NaiveMatches(queries, again, options));
  }
}

TEST(MatchPointsByProjection, FindsThePointsSeenAgain) {
  std::mt19937_64 random(3);
  const std::vector<PointFeature> points = RandomPoints(400, random);
  const std::vector<int> matches =
      MatchPointsByProjection(QueriesFor(points, 12.0), PointGrid(SeenAgain(points, random)), {});
  int right = 0;
  for (size_t i = 0; i < points.size(); ++i) right += matches[i] == static_cast<int>((i * 7 + 3) % 400) ? 1 : 0;
  EXPECT_EQ(right, 400);
}

// A corner that was found in two octaves, and its twin some pixels away.
TEST(Matching, TheSameCornerInAnotherOctaveIsNoRival) {
  std::mt19937_64 random(21);
  std::vector<PointFeature> points = RandomPoints(2, random);
  points[0].px = {100.0, 80.0};
  points[0].octave = 2;
  points[0].scale = 1.44;
  points[1] = points[0];
  points[1].octave = 3;
  points[1].scale = 1.728;
  PointQuery query{{101.0, 81.0}, 20.0, 2, 0.0F, points[0].descriptor};
  points[0].descriptor[1] ^= (uint64_t{1} << 20U) - 1U;
  points[1].descriptor[2] ^= (uint64_t{1} << 22U) - 1U;
  const auto match = [&](double apart_px) {
    points[1].px = points[0].px + Eigen::Vector2d(0.0, apart_px);
    const int by_projection = MatchPointsByProjection({query}, PointGrid(points), {})[0];
    const std::vector<Descriptor> descriptors = {points[0].descriptor, points[1].descriptor};
    EXPECT_EQ(MatchBruteForce({query.descriptor}, descriptors, {}, CornerPlacesOf(points))[0], by_projection);
    EXPECT_EQ(MatchBruteForce({query.descriptor}, descriptors, {})[0], -1);
    return by_projection;
  };
  EXPECT_EQ(match(0.0), 0);
  EXPECT_EQ(match(2.5), 0) << "1.5 pixels of the coarser octave are 2.6";
  EXPECT_EQ(match(2.7), -1);
}

TEST(MatchPointsByProjection, OctaveWindowAndRotation) {
  std::mt19937_64 random(4);
  std::vector<PointFeature> points = RandomPoints(50, random);
  std::vector<PointFeature> turned = points;
  for (PointFeature& p : turned) p.angle_rad = 0.3F;
  turned[7].angle_rad = 2.0F;
  MatchOptions options;
  options.check_rotation = true;
  std::vector<PointQuery> queries = QueriesFor(points, 5.0);
  queries[9].octave += 2;
  queries[11].octave = -1;
  const std::vector<int> matches = MatchPointsByProjection(queries, PointGrid(turned), options);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(matches[i], i == 7 || i == 9 ? -1 : i);
}

TEST(MatchPointsByProjection, TwoQueriesForOnePointLeaveTheNearer) {
  std::mt19937_64 random(5);
  const std::vector<PointFeature> points = RandomPoints(1, random);
  std::vector<PointQuery> queries(2, QueriesFor(points, 5.0)[0]);
  queries[0].descriptor[0] ^= 7;
  EXPECT_EQ(MatchPointsByProjection(queries, PointGrid(points), {}), (std::vector<int>{-1, 0}));
}

TEST(MatchPointsByProjection, NoQueriesNoPointsAndNaN) {
  std::mt19937_64 random(6);
  const std::vector<PointFeature> points = RandomPoints(3, random);
  EXPECT_TRUE(MatchPointsByProjection({}, PointGrid(points), {}).empty());
  std::vector<PointQuery> queries = QueriesFor(points, 5.0);
  EXPECT_EQ(MatchPointsByProjection(queries, PointGrid(), {}), (std::vector<int>{-1, -1, -1}));
  queries[1].px.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(MatchPointsByProjection(queries, PointGrid(points), {}), (std::vector<int>{0, -1, 2}));
}

TEST(MatchBruteForce, EqualsTheDefinition) {
  std::mt19937_64 random(7);
  std::vector<Descriptor> a;
  std::vector<Descriptor> b;
  for (int i = 0; i < 200; ++i) a.push_back(RandomDescriptor(random));
  for (int i = 0; i < 150; ++i) b.push_back(Flipped(a[(i * 3) % 200], 40, random));
  MatchOptions options;
  options.ratio = 0.9;
  const std::vector<int> matches = MatchBruteForce(a, b, options);
  for (size_t i = 0; i < a.size(); ++i) {
    int best = -1, distance = 1000, second = 1000;
    for (size_t j = 0; j < b.size(); ++j) {
      const int d = HammingDistance(a[i], b[j]);
      if (d < distance) {
        second = distance, distance = d, best = static_cast<int>(j);
      } else {
        second = std::min(second, d);
      }
    }
    bool mutual = true;
    for (size_t k = 0; k < a.size(); ++k) {
      const int d = HammingDistance(a[k], b[best]);
      if (d < distance || (d == distance && k < i)) mutual = false;
    }
    const bool accepted = distance <= options.max_distance && distance < options.ratio * second && mutual;
    EXPECT_EQ(matches[i], accepted ? best : -1) << i;
  }
}

// A foreign message with two points at extreme coordinates.
TEST(PointGrid, PointsFarFromEachOtherTakeNoMemory) {
  for (const double far_px : {1e5, 1e6, 1e9, 1e300}) {
    std::vector<PointFeature> points(3);
    points[1].px = {far_px, far_px};
    points[2].px = {-far_px, far_px};
    const PointGrid grid(points);
    EXPECT_EQ(grid.Within({0.0, 0.0}, 10.0), (std::vector<int>{0})) << far_px;
    EXPECT_EQ(grid.Within({far_px, far_px}, 10.0), (std::vector<int>{1})) << far_px;
    EXPECT_EQ(grid.Within({-far_px, far_px}, 10.0), (std::vector<int>{2})) << far_px;
  }
}

TEST(MatchBruteForce, EmptyOneAndIdentical) {
  std::mt19937_64 random(8);
  const std::vector<Descriptor> one = {RandomDescriptor(random)};
  EXPECT_TRUE(MatchBruteForce({}, one, {}).empty());
  EXPECT_EQ(MatchBruteForce(one, {}, {}), (std::vector<int>{-1}));
  EXPECT_EQ(MatchBruteForce(one, one, {}), (std::vector<int>{0}));
  // Repeated texture: twice the same descriptor is no unique match.
  const std::vector<Descriptor> twice = {one[0], one[0]};
  MatchOptions options;
  EXPECT_EQ(MatchBruteForce({Flipped(one[0], 5, random)}, twice, options), (std::vector<int>{-1}));
}

}  // namespace
}  // namespace plslam
