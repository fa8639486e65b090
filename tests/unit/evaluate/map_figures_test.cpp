// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include "tests/unit/evaluate/drawn_texts.h"
#include "tests/unit/export/small_map.h"
#include "tools/evaluate/figures/pair_figure.h"
#include "tools/evaluate/figures/top_view.h"

namespace plslam::evaluate {
namespace {

using test::DrawnTexts;
using testing::Contains;
using testing::Not;

TEST(CovisibilityFigure, EdgesByTheirType) {
  StoredMap stored = test::SmallStoredMap();
  const std::vector<std::string> without = DrawnTexts(CovisibilityFigure("a map", stored.map));
  EXPECT_THAT(without, Contains("20 shared landmarks"));
  EXPECT_THAT(without, Not(Contains("loops")));
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = 2;
  stored.map.Add(loop);
  EXPECT_THAT(DrawnTexts(CovisibilityFigure("a map", stored.map)), Contains("loops"));
  EXPECT_THAT(DrawnTexts(CovisibilityFigure("no map", Map())), Contains("no map"));
}

TEST(TopView, PathsLandmarksAndEmptyPaths) {
  const StoredMap stored = test::SmallStoredMap();
  const NamedPath truth{"truth", {{-4, 0, 0}, {4, 0, 8}}, {{214, 39, 40}, 1.6, false}};
  const std::vector<std::string> texts = DrawnTexts(TopView("a run", {truth, {"estimate", {}, {}}}, &stored.map));
  for (const char* text : {"truth", "estimate", "points", "lines", "x [m]", "z [m]"}) {
    EXPECT_THAT(texts, Contains(text));
  }
  EXPECT_THAT(DrawnTexts(TopView("nothing", {}, nullptr)), Contains("nothing"));
  const NamedPath still{"still", {{0, 0, 0}, {0.01, 0, 0.01}}, {}};
  EXPECT_THAT(DrawnTexts(TopView("landmarks far outside", {still}, &stored.map)), Not(Contains("points")));
}

TEST(PairWorthShowing, LoopsBeforeNeighbours) {
  StoredMap stored = test::SmallStoredMap();
  EXPECT_EQ(PairWorthShowing(stored.map), (std::pair<KeyframeId, KeyframeId>{0, 1}));
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = 2;
  stored.map.Add(loop);
  loop.keyframe_id = 77;
  stored.map.Add(loop);
  EXPECT_EQ(PairWorthShowing(stored.map), (std::pair<KeyframeId, KeyframeId>{0, 2}))
      << "the newest whose keyframes are there";
  EXPECT_EQ(PairWorthShowing(Map()), std::nullopt);
}

TEST(PairFigure, SharedFeaturesHaveTheColourOfTheirLandmark) {
  const StoredMap stored = test::SmallStoredMap();
  const SameFeatures same = SharedBy(stored.map, 0, 2);
  EXPECT_EQ(same.points.size(), 60U);
  EXPECT_EQ(same.lines.size(), 4U);
  EXPECT_EQ(same.points[7], (std::pair{7, 7}));
  const cv::Mat image(480, 640, CV_8UC1, cv::Scalar(90));
  const PairedImage first{"one", image, &stored.features.at(0)}, second{"two", image, &stored.features.at(2)};
  const Drawing drawing = PairFigure("a pair", first, second, same);
  EXPECT_THAT(DrawnTexts(drawing), Contains("shared: points 60, lines 4"));
  const cv::Mat picture = ToPicture(drawing);
  EXPECT_GT(picture.cols, 1000);
  EXPECT_LT(PairFigure("wide", {"one", cv::Mat(100, 640, CV_8UC1, cv::Scalar(9)), first.features},
                       {"two", cv::Mat(100, 640, CV_8UC1, cv::Scalar(9)), second.features}, {})
                .size.y(),
            150.0)
      << "wide ones stand above each other";
}

}  // namespace
}  // namespace plslam::evaluate
