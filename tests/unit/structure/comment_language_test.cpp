// SPDX-License-Identifier: BSD-3-Clause
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

// Sentences that begin with one of these have their subject late or not at all.
constexpr double kMostWithoutSubject = 0.01;
// Shorter ones are noun phrases.
constexpr int kSentenceWords = 4;
// Characters of the name of a test, and of a suite.
constexpr size_t kLongestName = 45;

struct Sentence {
  std::string path;
  size_t line = 0;
  std::string text;

  std::string Where() const { return path + ":" + std::to_string(line) + ": " + text; }
};

int CountWords(const std::string& text) {
  static const std::regex kWord(R"(\S+)");
  return static_cast<int>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), kWord), std::sregex_iterator()));
}

// A sentence ends at a full stop, colon, question or exclamation mark before a capital letter or code.
void Split(const std::string& comment, const std::string& path, size_t line, std::vector<Sentence>& sentences) {
  static const std::regex kEnd(R"([.:!?]\s+(?=[A-Z`]))");
  std::sregex_token_iterator part(comment.begin(), comment.end(), kEnd, -1);
  for (; part != std::sregex_token_iterator(); ++part) {
    if (CountWords(*part) >= kSentenceWords) sentences.push_back({path, line, *part});
  }
}

struct Comment {
  size_t line = 0;
  std::string text;
  bool is_of_lines = true;  ///< false: behind code, where noun phrases begin with a small letter
};

// Comments of whole lines, consecutive ones joined, and those behind code.
std::vector<Comment> Comments(const test::SourceFile& file) {
  static const std::regex kWhole(R"(^\s*///?(<?)\s?(.*)$)");
  static const std::regex kBehindCode(R"([;{,)]\s+///?<?\s?(.*)$)");
  std::vector<Comment> comments;
  bool continues = false;
  for (size_t i = 1; i < file.lines.size(); ++i) {
    const std::string& line = file.lines[i];
    std::smatch match;
    if (std::regex_match(line, match, kWhole)) {
      if (!continues) comments.push_back({i + 1, "", match.length(1) == 0});
      comments.back().text += match[2].str() + " ";
      continues = true;
      continue;
    }
    continues = false;
    if (std::regex_search(line, match, kBehindCode)) comments.push_back({i + 1, match[1], false});
  }
  return comments;
}

std::vector<Sentence> Sentences(const test::SourceFile& file) {
  std::vector<Sentence> sentences;
  for (const Comment& comment : Comments(file)) Split(comment.text, file.path, comment.line, sentences);
  return sentences;
}

// Beginnings of comments, and of sentences in them, with a word in small letters. Identifiers have a capital letter, a
// digit or punctuation, variables a single letter; code in lines of its own is indented.
std::vector<Sentence> SmallBeginnings(const test::SourceFile& file) {
  static const std::regex kBegin(R"((?:^|[^.][.?!] {1,2})(?=[a-z]))");
  static const std::regex kWord(R"(^(?:[a-z]{2,}(?:[ ,;)'-]|:(?!:)|\.(?![a-z])|$)|a [a-z]{2,}))");
  std::vector<Sentence> found;
  for (const Comment& comment : Comments(file)) {
    for (std::sregex_iterator begin(comment.text.begin(), comment.text.end(), kBegin), end; begin != end; ++begin) {
      const bool is_first = begin->length() == 0;
      const std::string text = begin->suffix();
      if ((!is_first || comment.is_of_lines) && std::regex_search(text, kWord))
        found.push_back({file.path, comment.line, text});
    }
  }
  return found;
}

struct TestName {
  std::string suite;
  std::string test;
  std::string where;
};

// The macro begins a line; a long name may be on the next one.
std::vector<TestName> TestNames(const test::SourceFile& file) {
  static const std::regex kTest(R"(^(?:TYPED_)?TEST(?:_[FP])?\(\s*(\w+),\s*(\w+)\))");
  std::vector<TestName> names;
  for (size_t i = 0; i < file.lines.size(); ++i) {
    if (file.lines[i].empty()) continue;
    const std::string text = file.lines[i] + (i + 1 < file.lines.size() ? file.lines[i + 1] : "");
    std::smatch match;
    if (!std::regex_search(text, match, kTest)) continue;
    names.push_back({match[1], match[2], file.path + ":" + std::to_string(i + 1)});
  }
  return names;
}

std::string Unquoted(const std::string& text) {
  static const std::regex kQuoted("\"[^\"]*\"|`[^`]*`");
  return std::regex_replace(text, kQuoted, "");
}

TEST(Language, SentencesBeginWithTheirSubject) {
  static const std::regex kWithoutSubject(R"(^(Of|What|Where|Whoever|Those|Whose|That)\b)");
  size_t all = 0;
  std::vector<Sentence> found;
  for (const test::SourceFile& file : test::AllSourceFiles()) {
    for (const Sentence& sentence : Sentences(file)) {
      ++all;
      if (std::regex_search(sentence.text, kWithoutSubject)) found.push_back(sentence);
    }
  }
  ASSERT_GT(all, 5000U) << "the comments are found";
  std::string list;
  for (const Sentence& sentence : found) list += sentence.Where() + "\n";
  EXPECT_LE(static_cast<double>(found.size()), kMostWithoutSubject * static_cast<double>(all)) << list;
}

TEST(Language, SentencesBeginWithACapitalLetter) {
  for (const test::SourceFile& file : test::AllSourceFiles()) {
    for (const Sentence& sentence : SmallBeginnings(file)) ADD_FAILURE() << sentence.Where();
  }
}

TEST(Language, SmallBeginningsAreRecognised) {
  const test::SourceFile file{
      "a.h",
      {"// SPDX", "/// pose of a frame, 0, 1, 2, ... in order. the next", "/// one. a keyframe. It is.",
       "///   solve(it)", "", "/// kNone: `nothing`. nullopt without. std::hypot is. x is",
       "/// 1. frame_id. symmetric.cpp has. cam0 too.", std::string("int a;  /") + "//< of a frame. the first",
       std::string("int b;  /") + "//< of a keyframe", "        ///< of a map", "/// a * x + b"}};
  std::vector<std::string> found;
  for (const Sentence& sentence : SmallBeginnings(file))
    found.push_back(std::to_string(sentence.line) + " " + sentence.text.substr(0, 6));
  EXPECT_EQ(found, (std::vector<std::string>{"2 pose o", "2 the ne", "2 a keyf", "6 nullop", "8 the fi"}));
}

TEST(Language, CommentsAreInTheFieldsWords) {
  static const std::regex kDialect(
      R"(\b([Tt]old|[Aa]new|[Ii]n the place of|[Nn]obody|[Ww]hoever|[Ss]aid of|[Gg]oes on)\b)");
  for (const test::SourceFile& file : test::AllSourceFiles()) {
    for (const Sentence& sentence : Sentences(file)) {
      EXPECT_FALSE(std::regex_search(Unquoted(sentence.text), kDialect)) << sentence.Where();
    }
  }
}

// Names, and sentences that failed expectations print.
TEST(Language, TestsAreInTheFieldsWords) {
  static const std::regex kDialect(
      R"(\b[Tt]old\b|Told[A-Z]|[Nn]obody|\banew\b|Anew\b|[Ww]hoever|[Ss]omebody|goes on\b)");
  size_t n = 0;
  for (const test::SourceFile& file : test::SourceFiles({"tests"})) {
    if (file.path.ends_with("comment_language_test.cpp")) continue;
    for (size_t i = 0; i < file.lines.size(); ++i, ++n) {
      EXPECT_FALSE(std::regex_search(file.lines[i], kDialect)) << file.path << ":" << i + 1 << ": " << file.lines[i];
    }
  }
  ASSERT_GT(n, 10'000U) << "the tests are found";
}

TEST(Language, SentencesAreRecognised) {
  const test::SourceFile file{
      "a.h",
      {"// SPDX", "/// Of a frame that was lost. Returns the", "/// pose of the frame: What `Of it` is left.",
       "int a;  // what no caller needs", "// Short one."}};
  std::vector<std::string> texts;
  for (const Sentence& sentence : Sentences(file)) texts.push_back(sentence.text);
  ASSERT_EQ(texts.size(), 4U);
  EXPECT_EQ(texts[0], "Of a frame that was lost");
  EXPECT_EQ(texts[1], "Returns the pose of the frame");
  EXPECT_EQ(texts[3], "what no caller needs");
  EXPECT_EQ(Unquoted("the `Of it` \"told\" rest"), "the   rest");
}

TEST(Language, TestNamesAreShort) {
  size_t n = 0;
  for (const test::SourceFile& file : test::SourceFiles({"tests"})) {
    for (const TestName& name : TestNames(file)) {
      ++n;
      for (const std::string& part : {name.suite, name.test}) {
        EXPECT_LE(part.size(), kLongestName) << name.where << ": " << part;
      }
    }
  }
  EXPECT_GT(n, 2000U) << "the tests are found";
}

TEST(Language, TestNamesAreRecognised) {
  const test::SourceFile file{
      "a.cpp",
      {"TEST(A, B) {", "}", "", "TYPED_TEST(C,", "           D) {", "}", "// TEST(A, Comment)", "TEST_P(E, F) {}"}};
  std::vector<std::string> found;
  for (const TestName& name : TestNames(file)) found.push_back(name.where + " " + name.suite + "." + name.test);
  EXPECT_EQ(found, (std::vector<std::string>{"a.cpp:1 A.B", "a.cpp:4 C.D", "a.cpp:8 E.F"}));
}

}  // namespace
}  // namespace plslam
