// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/report_json.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/files/bytes.h"
#include "viewer_headless/report/report_page.h"
#include "viewer_headless/report/table.h"

namespace plslam::viewer {
namespace {

using testing::HasSubstr;

/// Bit by bit, the slow twin: as in RFC 4648.
std::string SlowBase64(const std::string& bytes) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bits, text;
  for (const unsigned char byte : bytes) {
    for (int bit = 7; bit >= 0; --bit) bits += ((byte >> bit) & 1) != 0 ? '1' : '0';
  }
  while (bits.size() % 6 != 0) bits += '0';
  for (size_t i = 0; i < bits.size(); i += 6) text += alphabet[std::stoul(bits.substr(i, 6), nullptr, 2)];
  while (text.size() % 4 != 0) text += '=';
  return text;
}

TEST(ReportJson, Base64FollowsTheRfc) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  std::string bytes;
  for (int i = 0; i < 256; ++i) {
    bytes += static_cast<char>(i);
    ASSERT_EQ(Base64(bytes), SlowBase64(bytes)) << bytes.size() << " bytes";
  }
}

TEST(ReportJson, ColumnsAreLittleEndian) {
  EXPECT_EQ(LittleEndianBytes({"", 1, std::vector<int32_t>{1, -2}}), std::string("\1\0\0\0\xfe\xff\xff\xff", 8));
  EXPECT_EQ(LittleEndianBytes({"", 1, std::vector<uint16_t>{0x1234}}), "\x34\x12");
  EXPECT_EQ(LittleEndianBytes({"", 1, std::vector<float>{1.0F}}), std::string("\0\0\x80\x3f", 4));
  EXPECT_EQ(TypeName({"", 1, std::vector<float>{}}), "f32");
  EXPECT_EQ(TypeName({"", 1, std::vector<uint8_t>{}}), "u8");
}

TEST(ReportJson, EmptyReportIsComplete) {
  const auto json = nlohmann::json::parse(ReportJson({}));
  EXPECT_TRUE(json["whole"]);
  EXPECT_TRUE(json["path"].is_null());
  EXPECT_TRUE(json["map"].is_null());
  EXPECT_TRUE(json["facts"]["ate_m"].is_null());
  EXPECT_EQ(json["pictures"].size(), 0U);
}

TEST(ReportJson, NamesCannotEndThePage) {
  ReportData data;
  data.facts.dataset = "</script><script>alert(1)</script>\xff\xfe";
  data.processes.push_back(
      {.name = "</script>", .state = "running", .pace = "", .table = {{"<b>", 1, std::vector<float>{1.0F}}}});
  const std::string text = ReportJson(data);
  EXPECT_EQ(text.find('<'), std::string::npos);
  const auto json = nlohmann::json::parse(text);
  EXPECT_THAT(json["facts"]["dataset"].get<std::string>(), HasSubstr("</script><script>alert(1)</script>"));
  EXPECT_TRUE(json["processes"][0]["table"].contains("<b>"));
}

TEST(ReportJson, InvalidFeaturesAreLeftOut) {
  ReportPicture picture;
  picture.features.points = {{{10.5F, 3.0F}, 2.0F, 300}, {{NAN, 1.0F}, 1.0F, 1}, {{5.0F, -7.0F}, -1.0F, 0}};
  picture.features.segments = {{{1, 2}, {INFINITY, 4}, 4, 4, 1}, {{1, 2}, {3, 4}, 4, 5, 7}};
  ReportData data;
  data.pictures.push_back(picture);
  const auto features = nlohmann::json::parse(ReportJson(data))["pictures"][0]["features"];
  const std::vector<uint16_t> points{336, 96, 64, 160, 0, 65535};
  EXPECT_EQ(features["points"]["data"], Base64(LittleEndianBytes({"", 3, points})));
  EXPECT_EQ(features["point_ages"]["data"], Base64(std::string("\xff\0", 2)));
  EXPECT_EQ(features["segment_ages"]["data"], Base64("\7"));
  const std::vector<uint16_t> disparities{128, 160};
  EXPECT_EQ(features["segment_disparities"]["data"], Base64(LittleEndianBytes({"", 2, disparities})));
}

TEST(ReportJson, NumbersThatAreNotFiniteAreNull) {
  ReportData data;
  data.facts.length_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(nlohmann::json::parse(ReportJson(data))["facts"]["length_m"].is_null());
}

TEST(ReportPage, DataReplaceTheirPlaceholder) {
  EXPECT_EQ(FillTemplate("<a>\"PLSLAM_RUN_DATA\"</a>", "{\"$&\": 1}"), "<a>{\"$&\": 1}</a>");
  EXPECT_THROW(FillTemplate("<a></a>", "{}"), std::runtime_error);
}

TEST(ReportPage, WarningsReplaceTheirPlaceholder) {
  const std::string page = FillTemplate("<a>\"PLSLAM_RUN_WARNINGS\"</a><b>\"PLSLAM_RUN_DATA\"</b>", "{}");
  EXPECT_EQ(FillWarnings(page, "[\"</script>\"]"), "<a>[\"\\u003c/script>\"]</a><b>{}</b>");
  EXPECT_THROW(FillWarnings("<a></a>", "[]"), std::runtime_error);
}

// A run can be refined more than once.
TEST(ReportPage, TakesTheLastRefinement) {
  const std::string begin = "<script id=\"run-refinement\" type=\"application/json\">";
  const std::string page = "<a>" + begin + "\"PLSLAM_RUN_REFINEMENT\"</script>";
  const std::string once = FillRefinement(page, "{\"name\": \"<b>\"}").value();
  EXPECT_EQ(once, "<a>" + begin + "{\"name\": \"\\u003cb>\"}</script>");
  EXPECT_EQ(FillRefinement(once, "{}"), "<a>" + begin + "{}</script>");
  EXPECT_FALSE(FillRefinement("<a></a>", "{}"));
}

TEST(ReportSince, TextRoundTrip) {
  const ReportSince since{3, 2, 250, 17, 96, 4};
  EXPECT_EQ(since.Text(), "3.2.250.17.96.4");
  EXPECT_EQ(ReportSince::Parse(since.Text()), since);
  EXPECT_EQ(ReportSince::Parse(""), ReportSince());
  EXPECT_EQ(ReportSince::Parse(ReportSince().Text()), ReportSince());
}

TEST(ReportSince, NonsenseIsRefused) {
  for (const char* text : {"1", "1.2.3.4.5", "1.2.3.4.5.6.7", "1.2.3.4.5.", ".1.2.3.4.5", "a.b.c.d.e.f",
                           "1.2.3.4.5.99999999999999999999", "1.2.-9.4.5.6", "1 .2.3.4.5.6", "1.2.3.4.5.6\n",
                           "../../etc/passwd", "0x1.2.3.4.5.6"}) {
    EXPECT_FALSE(ReportSince::Parse(text)) << text;
  }
}

}  // namespace
}  // namespace plslam::viewer
