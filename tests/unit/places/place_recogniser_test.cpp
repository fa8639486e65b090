// SPDX-License-Identifier: BSD-3-Clause
#include "core/places/place_recogniser.h"

#include <gmock/gmock.h>

#include <limits>

#include "tests/unit/places/random_places.h"

namespace plslam {
namespace {

using testing::ElementsAre;

PlaceRecogniser SmallRecogniser(Merge merge = Merge::kBalanced) {
  PlaceOptions options;
  options.merge = merge;
  return {test::SmallVocabulary(FeatureType::kPoints), test::SmallVocabulary(FeatureType::kLines), options};
}

std::vector<KeyframeId> Ids(const std::vector<PlaceMatch>& matches) {
  std::vector<KeyframeId> ids;
  for (const PlaceMatch& match : matches) ids.push_back(match.keyframe_id);
  return ids;
}

TEST(PlaceRecogniser, FindsThePlaceSeenAgainByEveryMerge) {
  for (const auto& [name, merge] : ChoicesOf(Merge())) {
    PlaceRecogniser places = SmallRecogniser(merge);
    std::mt19937_64 random(3);
    std::vector<ImageFeatures> images;
    for (int id = 0; id < 50; ++id) {
      images.push_back(test::RandomFeatures(40, 20, random));
      places.Add(100 + id, places.Describe(images.back()));
    }
    for (const int i : {0, 17, 49}) {
      const auto matches = places.Query(places.Describe(test::SeenAgain(images[i], 2, random)), {}, 3);
      ASSERT_FALSE(matches.empty());
      EXPECT_EQ(matches[0].keyframe_id, 100 + i) << name;
      EXPECT_GT(matches[0].score, 1.2 * matches[1].score) << name;
    }
  }
}

TEST(PlaceRecogniser, QueryEqualsComparingWithEach) {
  for (const auto& [name, merge] : ChoicesOf(Merge())) {
    PlaceRecogniser places = SmallRecogniser(merge);
    std::mt19937_64 random(4);
    for (int id = 0; id < 60; ++id) {
      places.Add(id, places.Describe(test::RandomFeatures(100, id % 30, random)));
    }
    for (int id = 0; id < 60; id += 4) places.Remove(id);
    const PlaceDescription query = places.Describe(test::RandomFeatures(90, 20, random));
    const auto matches = places.Query(query, {}, 1000);
    size_t expected_matches = 0;
    for (int id = 0; id < 60; ++id) {
      EXPECT_EQ(places.Has(id), id % 4 != 0);
      if (places.Has(id) && places.Score(query, places.Of(id)) > 0.0) ++expected_matches;
    }
    EXPECT_EQ(matches.size(), expected_matches) << name;
    for (size_t i = 0; i < matches.size(); ++i) {
      const PlaceMatch slow = places.Compare(query, places.Of(matches[i].keyframe_id));
      EXPECT_NEAR(matches[i].score, slow.score, slow.score / 4096);
      EXPECT_NEAR(matches[i].score_points, slow.score_points, slow.score_points / 4096);
      EXPECT_NEAR(matches[i].score_lines, slow.score_lines, slow.score_lines / 4096);
      EXPECT_LE(matches[i].score, matches[i > 0 ? i - 1 : 0].score);
    }
  }
}

TEST(PlaceRecogniser, IdenticalImagesScoreOneAndComeById) {
  PlaceRecogniser places = SmallRecogniser();
  std::mt19937_64 random(5);
  const PlaceDescription description = places.Describe(test::RandomFeatures(150, 40, random));
  for (const KeyframeId id : {9, 2, 30, 4}) places.Add(id, description);
  const auto matches = places.Query(description, {}, 3);
  EXPECT_THAT(Ids(matches), ElementsAre(2, 4, 9));
  EXPECT_NEAR(matches[0].score, 1.0, 1e-3);
  EXPECT_NEAR(places.Score(description, description), 1.0, 1e-5);
}

TEST(PlaceRecogniser, ExcludedKeyframesAreReplacedByTheNext) {
  PlaceRecogniser places = SmallRecogniser();
  std::mt19937_64 random(6);
  const ImageFeatures image = test::RandomFeatures(150, 40, random);
  for (int id = 0; id < 6; ++id) {
    places.Add(id, places.Describe(test::SeenAgain(image, 4 * id, random)));
  }
  const auto excluded = [](KeyframeId id) { return id < 3; };
  EXPECT_THAT(Ids(places.Query(places.Describe(image), excluded, 2)), ElementsAre(3, 4));
  EXPECT_THAT(places.Query(places.Describe(image), {}, 0), testing::IsEmpty());
  EXPECT_THAT(places.Query(
                  places.Describe(image), [](KeyframeId) { return true; }, 5),
              testing::IsEmpty());
}

TEST(PlaceRecogniser, AddedAgainReplaces) {
  PlaceRecogniser places = SmallRecogniser();
  std::mt19937_64 random(7);
  const PlaceDescription first = places.Describe(test::RandomFeatures(150, 40, random));
  const PlaceDescription second = places.Describe(test::RandomFeatures(150, 40, random));
  places.Add(1, first);
  places.Add(1, second);
  EXPECT_EQ(places.size(), 1);
  EXPECT_EQ(places.Of(1).points, second.points);
  EXPECT_NEAR(places.Query(second, {}, 1)[0].score, 1.0, 1e-3);
  EXPECT_TRUE(places.Remove(1));
  EXPECT_FALSE(places.Remove(1));
  EXPECT_TRUE(places.Query(second, {}, 1).empty());
  EXPECT_THROW(places.Of(1), std::out_of_range);
}

TEST(PlaceRecogniser, NoFeaturesNoPlaces) {
  PlaceRecogniser places = SmallRecogniser();
  const PlaceDescription nothing = places.Describe(ImageFeatures{});
  EXPECT_TRUE(places.Query(nothing, {}, 5).empty());
  places.Add(1, nothing);
  EXPECT_TRUE(places.Query(nothing, {}, 5).empty());
  EXPECT_EQ(places.Score(nothing, nothing), 0.0);
  EXPECT_TRUE(places.Remove(1));
}

TEST(PlaceRecogniser, OneFeatureTypeIsEnough) {
  PlaceRecogniser places = SmallRecogniser();
  std::mt19937_64 random(8);
  const ImageFeatures points = test::RandomFeatures(1, 0, random);
  const ImageFeatures lines = test::RandomFeatures(0, 30, random);
  places.Add(1, places.Describe(points));
  places.Add(2, places.Describe(lines));
  EXPECT_THAT(Ids(places.Query(places.Describe(points), {}, 5)), ElementsAre(1));
  EXPECT_NEAR(places.Score(places.Describe(points), places.Of(1)), 1.0, 1e-5);
  EXPECT_THAT(Ids(places.Query(places.Describe(lines), {}, 5)), ElementsAre(2));
}

TEST(PlaceRecogniser, WrongVocabulariesAreNamed) {
  const Vocabulary points = test::SmallVocabulary(FeatureType::kPoints);
  const Vocabulary lines = test::SmallVocabulary(FeatureType::kLines);
  EXPECT_THROW(PlaceRecogniser(lines, points, {}), std::invalid_argument);
  EXPECT_THROW(PlaceRecogniser(points, points, {}), std::invalid_argument);
}

TEST(PlaceDescription, StereoAndImageFeaturesAreDescribedAlike) {
  const PlaceRecogniser places = SmallRecogniser();
  std::mt19937_64 random(9);
  const ImageFeatures image = test::RandomFeatures(20, 10, random);
  StereoFeatures stereo;
  for (const PointFeature& point : image.points) stereo.points.push_back({.left = point});
  for (const LineFeature& line : image.lines) stereo.lines.push_back({.left = line});
  const PlaceDescription a = places.Describe(image);
  const PlaceDescription b = places.Describe(stereo);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.lines, b.lines);
  EXPECT_EQ(a.n_points, 20);
  EXPECT_EQ(b.n_lines, 10);
  EXPECT_EQ(a.dispersion_points_px, b.dispersion_points_px);
  EXPECT_EQ(a.dispersion_lines_px, b.dispersion_lines_px);
}

TEST(PlaceDescription, DispersionIsTheRootOfBothVariances) {
  ImageFeatures features;
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {6.0, 0.0}, {6.0, 8.0}, {0.0, 8.0}}) {
    features.points.push_back({.px = {u, v}});
    features.lines.push_back({.segment = {{u - 3.0, v}, {u + 3.0, v}}});
  }
  PlaceDescription description = DescribeLayout(features);
  EXPECT_NEAR(description.dispersion_points_px, 5.0, 1e-12);
  EXPECT_NEAR(description.dispersion_lines_px, 5.0, 1e-12);
  features.points.push_back({.px = {std::numeric_limits<double>::quiet_NaN(), 1.0}});
  description = DescribeLayout(features);
  EXPECT_EQ(description.n_points, 5);
  EXPECT_NEAR(description.dispersion_points_px, 5.0, 1e-12);
  EXPECT_EQ(DescribeLayout(ImageFeatures{}).dispersion_points_px, 0.0);
}

TEST(PlaceWeights, EqualThoseOfThePaper) {
  PlaceDescription query;
  query.n_points = 300;
  query.n_lines = 100;
  query.dispersion_points_px = 120.0;
  query.dispersion_lines_px = 180.0;
  const auto points = [&](Merge merge, double line_weight = 0.5) {
    const PlaceWeights weights = WeightsFor(query, {.merge = merge, .line_weight = line_weight});
    EXPECT_DOUBLE_EQ(weights.points + weights.lines, 1.0);
    return weights.points;
  };
  EXPECT_DOUBLE_EQ(points(Merge::kPaper), 0.5 * (0.75 + 0.4));
  EXPECT_DOUBLE_EQ(points(Merge::kStrength), 0.75);
  EXPECT_DOUBLE_EQ(points(Merge::kDispersion), 0.4);
  EXPECT_DOUBLE_EQ(points(Merge::kPoints), 1.0);
  EXPECT_DOUBLE_EQ(points(Merge::kLines), 0.0);
  EXPECT_DOUBLE_EQ(points(Merge::kBalanced), 300.0 / 350.0);
  EXPECT_DOUBLE_EQ(points(Merge::kBalanced, 1.0), 0.75);
  EXPECT_DOUBLE_EQ(WeightsFor({}, {.merge = Merge::kBalanced}).points, 0.5);
}

TEST(PlaceWeights, AdaptiveTrustsImagesOfFewFeaturesLess) {
  PlaceDescription query;
  query.n_points = 300;
  query.n_lines = 100;
  EXPECT_DOUBLE_EQ(WeightsFor(query, {.merge = Merge::kAdaptive}).points, 300.0 / 370.0);
  EXPECT_DOUBLE_EQ(WeightsFor(query, {.merge = Merge::kAdaptive}).lines, 50.0 / 370.0);
  EXPECT_EQ(WeightsFor({}, {.merge = Merge::kAdaptive}).points, 0.0);
}

TEST(WordWeights, DecreaseWithTheShareOfPlacesWithTheWord) {
  const std::vector<int> places_with{0, 1, 50, 95};
  const std::vector<float> word_weights =
      WordWeights(places_with, 95, {.merge = Merge::kAdaptive, .idf_exponent = 2.0});
  EXPECT_THAT(word_weights, ElementsAre(1.0F, testing::FloatEq(0.9801F), 0.25F, testing::FloatNear(0.0025F, 1e-7F)));
  EXPECT_THAT(WordWeights(places_with, 95, {.merge = Merge::kAdaptive, .idf_exponent = 0.0}), testing::Each(1.0F));
  EXPECT_THAT(WordWeights(places_with, 95, {.merge = Merge::kBalanced}), testing::Each(1.0F));
  EXPECT_THAT(WordWeights({0, 0}, 0, {.merge = Merge::kAdaptive}), testing::Each(1.0F));
}

// Two places with the same share of words in common with the query; the common words of one occur everywhere.
TEST(PlaceRecogniser, AdaptiveMergeDownweightsCommonWords) {
  std::mt19937_64 random(11);
  const auto take = [](const ImageFeatures& from, size_t begin, size_t end, ImageFeatures& to) {
    for (size_t i = begin; i < end; ++i) {
      to.points.push_back(from.points[i]);
      to.lines.push_back(from.lines[i]);
    }
  };
  const ImageFeatures door = test::RandomFeatures(20, 20, random);
  const ImageFeatures own = test::RandomFeatures(20, 20, random);
  const auto score = [&](Merge merge) {
    PlaceRecogniser places = SmallRecogniser(merge);
    ImageFeatures query = door;
    take(own, 0, 20, query);
    places.Add(0, places.Describe(own));
    for (int id = 1; id < 40; ++id) places.Add(id, places.Describe(door));
    const PlaceDescription description = places.Describe(query);
    return places.Score(description, places.Of(0)) / places.Score(description, places.Of(1));
  };
  EXPECT_GT(score(Merge::kAdaptive), 3.0 * score(Merge::kBalanced));
}

}  // namespace
}  // namespace plslam
