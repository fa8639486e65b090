// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/place_evaluation.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <numbers>

#include "tests/unit/places/random_places.h"
#include "tools/evaluate/places/place_report.h"

namespace plslam::evaluate {
namespace {

/// Precision and recall by counting again for each threshold; the area by the definition.
double SlowArea(const std::vector<ScoredProposal>& proposals, int positives) {
  std::vector<double> scores;
  for (const ScoredProposal& p : proposals) scores.push_back(p.score);
  std::sort(scores.rbegin(), scores.rend());
  double area = 0.0;
  double recall = 0.0;
  for (const double score : scores) {
    int right = 0;
    int all = 0;
    for (const ScoredProposal& p : proposals) {
      all += p.score >= score ? 1 : 0;
      right += p.score >= score && p.right ? 1 : 0;
    }
    area += 1.0 * right / all * (1.0 * right / positives - recall);
    recall = 1.0 * right / positives;
  }
  return area;
}

TEST(PrecisionRecall, EqualsCountingForEachThreshold) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 20; ++round) {
    std::vector<ScoredProposal> proposals;
    for (int i = 0; i < 60; ++i) proposals.push_back({0.05 * static_cast<double>(random() % 20), random() % 3 == 0});
    EXPECT_NEAR(ComputePrecisionRecall(proposals, 40).area, SlowArea(proposals, 40), 1e-12);
  }
}

TEST(PrecisionRecall, RecallAtFullPrecisionEndsAtTheFirstWrongOne) {
  const PrecisionRecall result =
      ComputePrecisionRecall({{0.9, true}, {0.8, true}, {0.7, false}, {0.6, true}, {0.5, true}}, 8);
  EXPECT_DOUBLE_EQ(result.recall_at_full_precision, 0.25);
  EXPECT_DOUBLE_EQ(result.curve.back().recall, 0.5);
  EXPECT_DOUBLE_EQ(result.curve.back().precision, 0.8);
  EXPECT_DOUBLE_EQ(ComputePrecisionRecall({{0.9, true}, {0.9, false}}, 1).recall_at_full_precision, 0.0);
}

TEST(PrecisionRecall, PerfectAndEmpty) {
  EXPECT_DOUBLE_EQ(ComputePrecisionRecall({{0.9, true}, {0.8, true}, {0.1, false}}, 2).area, 1.0);
  EXPECT_EQ(ComputePrecisionRecall({}, 3).area, 0.0);
  EXPECT_EQ(ComputePrecisionRecall({{0.5, false}}, 0).area, 0.0);
  EXPECT_TRUE(ComputePrecisionRecall({{0.5, false}}, 0).curve.empty());
}

TimedPose At(double t_s, double x_m, double yaw_deg) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()));
  return {static_cast<int64_t>(1e9 * t_s), SE3(q, Eigen::Vector3d(x_m, 0.0, 0.0))};
}

TEST(Revisits, PartlyOverlappingViewsAreNeitherRightNorWrong) {
  const RevisitOptions options;
  const TimedPose here = At(0.0, 0.0, 0.0);
  EXPECT_EQ(ClassifyPair(At(10.0, 0.9, 20.0), here, options), PairTruth::kRevisit);
  EXPECT_EQ(ClassifyPair(At(10.0, 2.0, 20.0), here, options), PairTruth::kIgnored);
  EXPECT_EQ(ClassifyPair(At(10.0, 0.5, 60.0), here, options), PairTruth::kIgnored);
  EXPECT_EQ(ClassifyPair(At(10.0, 6.0, 0.0), here, options), PairTruth::kOtherPlace);
  EXPECT_EQ(ClassifyPair(At(10.0, 0.0, 100.0), here, options), PairTruth::kOtherPlace);
  EXPECT_EQ(ClassifyPair(At(4.0, 0.0, 0.0), here, options), PairTruth::kIgnored);
  EXPECT_EQ(ClassifyPair(At(4.0, 9.0, 0.0), here, options), PairTruth::kIgnored);
  EXPECT_EQ(ClassifyPair(here, At(10.0, 0.9, 20.0), options), PairTruth::kRevisit);
}

/// Two laps of ten places, 10 m and 10 s apart.
std::vector<PlaceFrame> TwoLaps(const PlaceRecogniser& places, int bits) {
  std::mt19937_64 random(2);
  std::vector<ImageFeatures> images;
  for (int i = 0; i < 10; ++i) images.push_back(test::RandomFeatures(40, 20, random));
  std::vector<PlaceFrame> frames;
  for (int i = 0; i < 20; ++i) {
    frames.push_back(
        {At(10.0 * i, 10.0 * (i % 10), 0.0), places.Describe(test::SeenAgain(images[i % 10], bits, random))});
  }
  return frames;
}

TEST(PlaceEvaluation, TwoLapsAreRecognisedOnlyIfSimilar) {
  const PlaceRecogniser places(test::SmallVocabulary(FeatureType::kPoints),
                               test::SmallVocabulary(FeatureType::kLines), {});
  const auto evaluate = [&](int bits) {
    return EvaluatePlaces("laps", TwoLaps(places, bits), places.point_vocabulary(), places.line_vocabulary(), {});
  };
  const PlaceEvaluation alike = evaluate(1);
  EXPECT_EQ(alike.frames, 20);
  EXPECT_EQ(alike.revisiting_frames, 10);
  EXPECT_EQ(alike.revisits, 10);
  EXPECT_EQ(alike.other_places, 190 - 10);
  ASSERT_EQ(alike.merges.size(), 7U);
  EXPECT_EQ(alike.merges[0].merge, PlaceOptions().merge);
  for (const MergeEvaluation& m : alike.merges) {
    EXPECT_DOUBLE_EQ(m.best_match.area, 1.0) << NameOf(m.merge);
    EXPECT_DOUBLE_EQ(m.all_pairs.recall_at_full_precision, 1.0) << NameOf(m.merge);
  }
  EXPECT_NEAR(alike.similarities.points.At(3, 3), 1.0, 1e-5);
  EXPECT_GT(alike.similarities.points.At(13, 3), 2.0F * alike.similarities.points.At(13, 4));
  for (const MergeEvaluation& m : evaluate(200).merges) EXPECT_LT(m.all_pairs.area, 0.6) << NameOf(m.merge);
}

TEST(PlaceEvaluation, NoFramesAndOneFrame) {
  const PlaceRecogniser places(test::SmallVocabulary(FeatureType::kPoints),
                               test::SmallVocabulary(FeatureType::kLines), {});
  for (const size_t count : {0U, 1U}) {
    std::vector<PlaceFrame> frames = TwoLaps(places, 1);
    frames.resize(count);
    const PlaceEvaluation evaluation =
        EvaluatePlaces("short", frames, places.point_vocabulary(), places.line_vocabulary(), {});
    EXPECT_EQ(evaluation.revisits, 0);
    EXPECT_EQ(evaluation.merges[0].best_match.area, 0.0);
    EXPECT_FALSE(ToPicture(SimilarityFigure("short", evaluation.similarities, "frames")).empty());
    EXPECT_FALSE(ToPicture(PrecisionRecallFigure(evaluation)).empty());
  }
}

TEST(PlaceEvaluation, PicturesAndReportsShowTheNumbers) {
  const PlaceRecogniser places(test::SmallVocabulary(FeatureType::kPoints),
                               test::SmallVocabulary(FeatureType::kLines), {});
  const PlaceEvaluation evaluation =
      EvaluatePlaces("laps", TwoLaps(places, 1), places.point_vocabulary(), places.line_vocabulary(), {});
  // The matrix of points, 78.7 pt for 20 frames, begins at (2, 30).
  const cv::Mat picture = ToPicture(SimilarityFigure("laps", evaluation.similarities, "frames"), 10.0 * 72.0);
  const auto pixel = [&](int row, int column) {
    return picture.at<cv::Vec3b>(300 + 39 * row + 20, 20 + 39 * column + 20);
  };
  // Viridis: yellow on the diagonal, violet for dissimilar pairs.
  EXPECT_GT(pixel(0, 0)[1], 200) << pixel(0, 0);
  EXPECT_LT(pixel(0, 3)[1], 100) << pixel(0, 3);
  EXPECT_GT(pixel(13, 3)[1], 200) << "the second lap: " << pixel(13, 3);
  EXPECT_THAT(PlaceTable(evaluation), testing::HasSubstr("20 frames, 10 of them at revisited places"));
  const auto json = PlacesToJson({evaluation}, {});
  EXPECT_EQ(json["sequences"][0]["merges"]["paper"]["best_match"]["area"].get<double>(), 1.0);
  EXPECT_EQ(json["revisit"]["min_gap_s"].get<double>(), 5.0);
}

}  // namespace
}  // namespace plslam::evaluate
