// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/drawing/drawing.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <set>

#include "tests/support/shell.h"
#include "tests/unit/evaluate/drawn_texts.h"
#include "tools/evaluate/drawing/axes.h"
#include "tools/evaluate/figures/runtime_figure.h"
#include "tools/evaluate/figures/top_view.h"

namespace plslam::evaluate {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing::ThrowsMessage;

Drawing SomeDrawing() {
  Drawing drawing;
  drawing.size = {60.0, 40.0};
  drawing.shapes.emplace_back(
      DrawnPath{{{10, 10}, {30, 10}, {30, 20}, {10, 20}}, {{0, 0, 0}, 0.0}, Ink{200, 30, 10}});
  drawing.shapes.emplace_back(DrawnSegments{{{Place(5, 35), Place(55, 35)}}, {{0, 0, 255}, 2.0, true}});
  drawing.shapes.emplace_back(DrawnDots{{{45, 15}}, 4.0, {0, 160, 0}});
  drawing.shapes.emplace_back(DrawnText{{2, 8}, "a < b & \"c\" \x01", 6.0, 0.0, {0, 0, 0}});
  drawing.shapes.emplace_back(DrawnImage{{40, 25}, {10, 5}, cv::Mat(2, 4, CV_8UC1, cv::Scalar(128))});
  return drawing;
}

cv::Vec3b At(const cv::Mat& picture, double x_pt, double y_pt, double scale) {
  return picture.at<cv::Vec3b>(static_cast<int>(y_pt * scale), static_cast<int>(x_pt * scale));
}

TEST(Drawing, ShapesHaveTheirPixelPositions) {
  const cv::Mat picture = ToPicture(SomeDrawing(), 5.0 * 72.0);
  ASSERT_EQ(picture.size(), cv::Size(300, 200));
  EXPECT_EQ(At(picture, 20, 15, 5.0), cv::Vec3b(10, 30, 200));
  EXPECT_EQ(At(picture, 45, 15, 5.0), cv::Vec3b(0, 160, 0));
  EXPECT_EQ(At(picture, 45, 27, 5.0), cv::Vec3b(128, 128, 128));
  EXPECT_EQ(At(picture, 6.5, 35, 5.0), cv::Vec3b(255, 0, 0)) << "in the first dash";
  EXPECT_EQ(At(picture, 8.6, 35, 5.0), cv::Vec3b(255, 0, 0)) << "round end of the dash";
  EXPECT_EQ(At(picture, 35, 15, 5.0), cv::Vec3b(255, 255, 255));
}

TEST(Drawing, TheEndingOfTheFileChoosesTheFormat) {
  const ScratchFolder folder;
  for (const auto& [name, begin] : {std::pair{"a.svg", "<?xml"}, {"a.PDF", "%PDF-"}, {"a.png", "\x89PNG"}}) {
    WriteDrawing(folder.Path(name), SomeDrawing());
    EXPECT_THAT(ReadText(folder.Path(name)), StartsWith(begin)) << name;
  }
  for (const char* name : {"a.jpg", "a", "a.svg.gz"}) {
    EXPECT_THAT([&] { WriteDrawing(folder.Path(name), SomeDrawing()); },
                ThrowsMessage<std::runtime_error>(
                    HasSubstr(std::string(name) + ": a drawing is written as .svg, .pdf or .png")));
  }
}

TEST(Drawing, UnwritableFilesAreNamedWithTheReason) {
  for (const char* ending : {".svg", ".pdf", ".png"}) {
    const auto write_to = [&](const std::string& folder) { WriteDrawing(folder + "/a" + ending, SomeDrawing()); };
    EXPECT_THAT([&] { write_to("/nowhere"); },
                ThrowsMessage<std::runtime_error>(
                    AllOf(HasSubstr(std::string("/nowhere/a") + ending), HasSubstr("cannot be created"))));
  }
}

TEST(Drawing, TheSameDrawingIsTheSameFile) {
  EXPECT_EQ(ToSvg(SomeDrawing()), ToSvg(SomeDrawing()));
  EXPECT_EQ(ToPdf(SomeDrawing()), ToPdf(SomeDrawing()));
  EXPECT_THAT(ToPdf(SomeDrawing()), Not(HasSubstr("Date")));
  EXPECT_EQ(cv::norm(ToPicture(SomeDrawing()), ToPicture(SomeDrawing()), cv::NORM_INF), 0.0);
}

/// Returns the text between each `key` and the next quotation mark.
std::vector<std::string> Quoted(const std::string& text, const std::string& key) {
  std::vector<std::string> found;
  for (size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    found.push_back(text.substr(at + key.size(), text.find('"', at + key.size()) - at - key.size()));
  }
  return found;
}

TEST(Drawing, IdsOfAnSvgBeginWithThePrefixAndFitTheirUses) {
  const std::string svg = ToSvg(SomeDrawing(), "first_");
  const std::vector<std::string> ids = Quoted(svg, " id=\""), uses = Quoted(svg, "\"#");
  EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), ids.size());
  EXPECT_THAT(ids, testing::Each(StartsWith("first_")));
  EXPECT_GT(uses.size(), 5U) << "letters, and a picture";
  for (const std::string& use : uses) EXPECT_THAT(ids, Contains(use));
}

TEST(Drawing, SvgWithSpecialCharactersIsWellFormed) {
  const ScratchFolder folder;
  const std::string path = folder.Write("a.svg", ToSvg(SomeDrawing()));
  EXPECT_THAT(ReadText(path), HasSubstr("width=\"60pt\" height=\"40pt\""));
  PLSLAM_REQUIRE_PROGRAM("python3");
  const auto parsed =
      test::Shell(folder, "python3 -c 'import sys, xml.dom.minidom as m; m.parse(sys.argv[1])' " + path);
  EXPECT_EQ(parsed.exit_code, 0) << parsed.error;
}

TEST(Drawing, TextOfAPdfCanBeSearched) {
  PLSLAM_REQUIRE_PROGRAM("pdftotext");
  const ScratchFolder folder;
  const auto text = test::Shell(folder, "pdftotext " + folder.Write("a.pdf", ToPdf(SomeDrawing())) + " -");
  EXPECT_THAT(text.out, HasSubstr("a < b & \"c\" ?"));
}

TEST(Drawing, RsvgDrawsTheSvgLikeOurPicture) {
  PLSLAM_REQUIRE_PROGRAM("rsvg-convert");
  const ScratchFolder folder;
  const std::string path = folder.Write("a.svg", ToSvg(SomeDrawing()));
  const auto drawn = test::Shell(folder, "rsvg-convert -w 300 -h 200 " + path + " -o " + folder.Path("a.png"));
  ASSERT_EQ(drawn.exit_code, 0) << drawn.error;
  EXPECT_GT(std::filesystem::file_size(folder.Path("a.png")), 500U);
}

int Ink(const Drawing& drawing) {
  const cv::Mat picture = ToPicture(drawing, 2.0 * 72.0);
  return cv::countNonZero(picture.reshape(1) != 255);
}

TEST(Drawing, EmptyAndInvalidShapesDrawNothing) {
  Drawing drawing;
  drawing.size = {20.0, 10.0};
  drawing.shapes.emplace_back(DrawnPath{});
  drawing.shapes.emplace_back(DrawnSegments{});
  drawing.shapes.emplace_back(DrawnDots{{{1e12, -1e12}}, 1.0, {}});
  drawing.shapes.emplace_back(DrawnImage{{100, 100}, {5, 5}, cv::Mat(2, 2, CV_8UC1, cv::Scalar(0))});
  drawing.shapes.emplace_back(DrawnImage{{3, 3}, {5, 5}, cv::Mat()});
  drawing.shapes.emplace_back(DrawnText{});
  EXPECT_EQ(Ink(drawing), 0);
}

TEST(Drawing, PathOfAStandingCameraIsADot) {
  Drawing drawing;
  drawing.size = {20.0, 10.0};
  drawing.shapes.emplace_back(DrawnPath{{{3, 3}, {3, 3}}, {{0, 0, 0}, 1.0, false}, std::nullopt});
  EXPECT_GT(Ink(drawing), 0);
}

// If fontconfig finds no font, cairo draws with its own: text never vanishes.
TEST(Drawing, TextIsThereWithoutAnyFont) {
  const ScratchFolder folder;
  const std::string settings = folder.Write("fonts.conf",
                                            "<?xml version=\"1.0\"?><!DOCTYPE fontconfig SYSTEM \"fonts.dtd\">"
                                            "<fontconfig><dir>/nowhere</dir></fontconfig>");
  const auto draws = [](const std::string& text) {
    Drawing drawing;
    drawing.size = {60.0, 10.0};
    AddText(drawing, {2.0, 8.0}, text);
    return drawing;
  };
  const auto check = [&] {
    setenv("FONTCONFIG_FILE", settings.c_str(), 1);
    const bool drawn =
        Ink(draws("text")) > 100 && TextWidth("text", 7.0) > 5.0 && ToSvg(draws("ab")) != ToSvg(draws("cd"));
    std::exit(drawn ? 0 : 1);
  };
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(check(), testing::ExitedWithCode(0), "");
}

TEST(Axes, LogarithmsAndMarks) {
  Drawing drawing;
  drawing.size = {120.0, 60.0};
  Axes axes(drawing, {{10, 10}, {100, 40}}, {1.0, 100.0}, {0.0, 1.0}, true);
  EXPECT_NEAR(axes.At(10.0, 0.5).x(), 60.0, 1e-9);
  EXPECT_NEAR(axes.At(10.0, 0.5).y(), 30.0, 1e-9);
  EXPECT_TRUE(axes.Contains(100.0, 1.0));
  EXPECT_FALSE(axes.Contains(0.9, 1.0));
  axes.DrawGrid("t [ms]", "");
  EXPECT_THAT(test::DrawnTexts(drawing), testing::ElementsAre("1", "10", "100", "t [ms]"));
}

TEST(Axes, MarksAreOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(MarkDistance(10.0, 11), 1.0);
  EXPECT_DOUBLE_EQ(MarkDistance(10.0, 6), 2.0);
  EXPECT_DOUBLE_EQ(MarkDistance(10.0, 4), 5.0);
  EXPECT_DOUBLE_EQ(MarkDistance(0.03, 4), 0.01);
  EXPECT_NEAR(MarkDistance(7e8, 8), 1e8, 1.0);
}

TEST(Axes, LongTitlesAreCut) {
  Drawing drawing;
  drawing.size = {kColumn_pt, 20.0};
  AddTitle(drawing, std::string(300, 'w'));
  const auto& text = std::get<DrawnText>(drawing.shapes.at(0));
  EXPECT_THAT(text.text, testing::EndsWith("..."));
  EXPECT_LT(TextWidth(text.text, text.size_pt), kColumn_pt);
}

std::vector<Eigen::Vector3d> Ellipsoid(double x, double y, double z) {
  std::vector<Eigen::Vector3d> path;
  for (int i = 0; i < 100; ++i) path.push_back({x * std::sin(0.1 * i), y * std::sin(0.2 * i), z * std::cos(0.1 * i)});
  return path;
}

TEST(ViewOf, LevelAndClimbingPaths) {
  const auto expect = [](const std::vector<Eigen::Vector3d>& path, const char* right, const char* up) {
    const ViewDirections view = ViewOf(path, -Eigen::Vector3d::UnitY());
    EXPECT_EQ(view.right_name, right);
    EXPECT_EQ(view.up_name, up);
    // Right, up and towards the viewer are right-handed; the viewer is above (-y) or beside the path.
    const Eigen::Vector3d towards = view.right.cross(view.up);
    EXPECT_TRUE(towards.isApprox(-Eigen::Vector3d::UnitY()) || std::string(up) == "-y [m]") << towards.transpose();
  };
  expect(Ellipsoid(5, 1, 5), "x [m]", "z [m]");
  expect(Ellipsoid(1, 1, 9), "z [m]", "-x [m]");
  expect(Ellipsoid(1, 8, 5), "z [m]", "-y [m]");
  expect(Ellipsoid(6, 8, 1), "x [m]", "-y [m]");
  expect({}, "x [m]", "z [m]");
}

TEST(ViewOf, AboveIsInTheUpDirection) {
  const Eigen::Vector3d up_w = Eigen::Vector3d(0.1, -1.0, 0.5).normalized();
  const ViewDirections view = ViewOf(Ellipsoid(5, 1, 5), up_w);
  EXPECT_TRUE(view.right.cross(view.up).isApprox(up_w));
}

TEST(PlanAround, EqualScaleAroundEverything) {
  const Plan plan = PlanAround({{0.0, 0.0}, {100.0, 40.0}}, 20.0);
  const double x_scale = plan.area.size.x() / (plan.x.max - plan.x.min);
  EXPECT_NEAR(x_scale, plan.area.size.y() / (plan.y.max - plan.y.min), 1e-9);
  EXPECT_LT(plan.x.min, 0.0);
  EXPECT_GT(plan.y.max, 40.0);
  const Plan point = PlanAround({{5.0, 5.0}}, 20.0);
  EXPECT_GT(point.x.max, point.x.min);
  EXPECT_GT(PlanAround({}, 20.0).height_pt, 100.0);
}

TEST(RuntimeFigure, OnlyStagesThatRan) {
  const auto summary = nlohmann::json::parse(R"({
    "stage_ms": {"track": {"median": 2.0, "p95": 6.5}, "total": {"median": 20.0, "p95": 30.0}},
    "map": {"keyframes": 5, "adjustment_ms": {"median": 33.0, "p95": 80.0}},
    "loop_closing": {"correct_ms": {"median": 0.0, "p95": 0.0}},
    "processes": {"vo": {"cpu_ms_per_frame": 25.5}}})");
  const std::vector<std::string> texts = test::DrawnTexts(RuntimeFigure("a run", summary));
  for (const char* text : {"track", "2 (6.5)", "adjustment", "33 (80)", "25.5"}) EXPECT_THAT(texts, Contains(text));
  EXPECT_THAT(texts, Not(Contains(HasSubstr("loop closing"))));
  EXPECT_THAT(texts, Not(Contains("correct")));
  EXPECT_THAT(test::DrawnTexts(RuntimeFigure("odometry alone", R"({"map": null, "loop_closing": null})"_json)),
              Contains("odometry alone"));
}

}  // namespace
}  // namespace plslam::evaluate
