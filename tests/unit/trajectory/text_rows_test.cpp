// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/text_rows.h"

#include <gmock/gmock.h>

#include "tests/support/text_file.h"

namespace plslam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

int64_t SecondsToNs(const std::string& text) {
  const std::string path = "file";
  return TextRow{&path, 1, {text}, false}.Scaled(0, 9);
}

TEST(TextRows, SecondsBecomeNanosecondsWithoutADouble) {
  EXPECT_EQ(SecondsToNs("1403636579.763555584"), 1403636579763555584);
  EXPECT_EQ(SecondsToNs("1.033914e-01"), 103391400);
  EXPECT_EQ(SecondsToNs("0"), 0);
  EXPECT_EQ(SecondsToNs(".5"), 500000000);
  EXPECT_EQ(SecondsToNs("7."), 7000000000);
  EXPECT_EQ(SecondsToNs("+2E1"), 20000000000);
  EXPECT_EQ(SecondsToNs("-0.000000001"), -1);
  EXPECT_EQ(SecondsToNs("0000000000000000000000000000001.5"), 1500000000);
  EXPECT_EQ(SecondsToNs("1e-400"), 0);
}

TEST(TextRows, DigitsBeyondTheNanosecondAreRounded) {
  EXPECT_EQ(SecondsToNs("0.0000000014999999999999999999999999"), 1);
  EXPECT_EQ(SecondsToNs("0.0000000015"), 2);
  EXPECT_EQ(SecondsToNs("-0.0000000015"), -2);
  EXPECT_EQ(SecondsToNs("0.9999999999"), 1000000000);
}

TEST(TextRows, LargestTimeAndOverflow) {
  EXPECT_EQ(SecondsToNs("9223372036.854775807"), INT64_MAX);
  for (const char* text : {"9223372036.854775808", "1403636579763555584", "1e300", "1e9999"}) {
    EXPECT_THAT([&] { SecondsToNs(text); }, ThrowsMessage<std::runtime_error>(HasSubstr("file:1: '"))) << text;
  }
}

TEST(TextRows, InvalidDecimalNumbersAreRefused) {
  for (const char* text :
       {"", "-", ".", "e5", "1e", "1e+", "1.2.3", "0x10", "nan", "inf", "1,5", "1e99999", "1e5 "}) {
    EXPECT_THROW(SecondsToNs(text), std::runtime_error) << text;
  }
}

TEST(TextRows, NumbersAreFiniteAndWhole) {
  const std::string path = "file";
  const TextRow row{&path, 3, {"1.5", "+2", "-3e-2", "1e-999", "nan", "inf", "1e999", "4x", ""}, false};
  EXPECT_EQ(row.Number(0), 1.5);
  EXPECT_EQ(row.Number(1), 2.0);
  EXPECT_EQ(row.Number(2), -0.03);
  EXPECT_EQ(row.Number(3), 0.0);
  for (size_t i = 4; i < row.fields.size(); ++i) {
    EXPECT_THAT([&] { row.Number(i); }, ThrowsMessage<std::runtime_error>(HasSubstr("file:3: '"))) << row.fields[i];
  }
}

TEST(TextRows, CommentsBlankLinesAndBothLineEndings) {
  const ScratchFolder folder;
  const std::string path = folder.Write("a.txt", "# head\r\n\r\n  1 2\t3 \r\n4, 5,\n   # more\n6");
  std::vector<std::vector<std::string>> rows;
  std::vector<int> lines;
  ForEachRow(path, [&](const TextRow& row) {
    rows.emplace_back(row.fields.begin(), row.fields.end());
    lines.push_back(row.line);
  });
  EXPECT_THAT(rows, ElementsAre(ElementsAre("1", "2", "3"), ElementsAre("4", "5", ""), ElementsAre("6")));
  EXPECT_THAT(lines, ElementsAre(3, 4, 6));
}

TEST(TextRows, ByteOrderMarkBeforeTheFirstLineIsNoText) {
  const ScratchFolder folder;
  std::vector<std::string> fields;
  const auto take = [&](const TextRow& row) { fields.emplace_back(row.fields[0]); };
  ForEachRow(folder.Write("a.txt", "\xEF\xBB\xBF# head\n1 2\n"), take);
  ForEachRow(folder.Write("b.txt",
                          "\xEF\xBB\xBF"
                          "3 4\n"),
             take);
  ForEachRow(folder.Write("c.txt",
                          "5\n\xEF\xBB\xBF"
                          "6\n"),
             take);
  EXPECT_THAT(fields, ElementsAre("1", "3", "5",
                                  "\xEF\xBB\xBF"
                                  "6"));
}

TEST(TextRows, HeaderOfACsvIsItsFirstRowWithALetter) {
  const ScratchFolder folder;
  std::vector<bool> headers;
  const auto take = [&](const TextRow& row) { headers.push_back(row.IsCsvHeader()); };
  ForEachRow(folder.Write("a.csv", "# comment\n\ntimestamp [ns],p_x\n1,2\nx,3\n"), take);
  ForEachRow(folder.Write("b.csv", "1,2\nx,3\n"), take);
  ForEachRow(folder.Write("c.txt", "P0: 1 2\n"), take);
  EXPECT_THAT(headers, ElementsAre(true, false, false, false, false, false));
}

TEST(TextRows, LineLengthLimitIs4096Characters) {
  const ScratchFolder folder;
  int rows = 0;
  ForEachRow(folder.Write("fits.txt", std::string(4096, '1') + "\n2"), [&](const TextRow&) { ++rows; });
  EXPECT_EQ(rows, 2);
  const std::string path = folder.Write("long.txt", "1\n" + std::string(5000, '1') + "\n");
  EXPECT_THAT([&] { ForEachRow(path, [](const TextRow&) {}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("long.txt:2: the line has more than 4096")));
}

TEST(TextRows, BinaryFilesAreRecognised) {
  const ScratchFolder folder;
  const std::string path = folder.Write("nul.txt", std::string("3\n1\0 \x1b[2J", 9));
  EXPECT_THAT([&] { ForEachRow(path, [](const TextRow&) {}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("nul.txt:2: is not text, but binary: '1\\x00 \\x1b[2J'")));
}

TEST(TextRows, MissingFileAndFolderAreNamed) {
  const ScratchFolder folder;
  EXPECT_THAT([&] { ForEachRow(folder.Path("none"), [](const TextRow&) {}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("none: cannot be read: No such file or directory")));
  EXPECT_THAT([&] { ForEachRow(folder.Path(""), [](const TextRow&) {}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("is a folder, not a file")));
}

}  // namespace
}  // namespace plslam
