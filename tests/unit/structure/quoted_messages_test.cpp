// SPDX-License-Identifier: BSD-3-Clause
// Messages that the documents quote, compared with the strings of the sources.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/data_folder.h"
#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

/// Stands for a value in a message, and for what "..." leaves out in a quote.
constexpr char kValue = '\x01';
constexpr char kGap = '\x02';
/// Share of the letters in words of a quote that must be fixed text of a message of the sources. The rest are words
/// that are values, as the name of a process.
constexpr double kFixedShare = 0.75;
/// Messages of other programs.
constexpr std::array kForeign = {"Unrecognized option: -Xincgc"};

/// Values of quoted messages that are words.
constexpr std::array kValuesOfWords = {"Permission denied", "process 1234 (plslam run ...)", "nanoseconds",
                                       "K of the left"};

/// The string literals of a statement, joined; `kValue` in place of format fields, and of code before, between and
/// after them.
using Message = std::string;

/// Appends the text of the literal that begins after the quote at `i`, and returns the index after its end.
size_t ReadLiteral(const std::string& code, size_t i, Message* message) {
  for (; i < code.size() && code[i] != '"'; ++i) {
    if (code[i] == '\\' && i + 1 < code.size()) {
      ++i;
      *message += code[i] == 'n' ? '\n' : code[i];
    } else if (code[i] == '{' && i + 1 < code.size() && code[i + 1] == '{') {
      *message += code[i++];
    } else if (code[i] == '{' && code.find('}', i) != std::string::npos) {
      i = code.find('}', i);
      *message += kValue;
    } else {
      *message += code[i];
    }
  }
  return i + 1;
}

std::vector<Message> MessagesOf(const test::SourceFile& file) {
  std::string code;
  for (const std::string& line : file.lines) {
    const size_t first = line.find_first_not_of(' ');
    if (first != std::string::npos && line.compare(first, 2, "//") != 0) code += line + "\n";
  }
  std::vector<Message> messages(1, {kValue});
  bool code_between = false;
  for (size_t i = 0; i < code.size();) {
    const char c = code[i];
    if (c == '\'' && i + 2 < code.size() && (code[i + 1] == '\\' || code[i + 2] == '\'')) {
      i += code[i + 1] == '\\' ? 4 : 3;
    } else if (c == '"') {
      if (code_between && messages.back().back() != kValue) messages.back() += kValue;
      code_between = false;
      i = ReadLiteral(code, i + 1, &messages.back());
    } else {
      if (c == ';' && messages.back().size() > 1) {
        if (messages.back().back() != kValue) messages.back() += kValue;
        messages.push_back({kValue});
      }
      code_between = code_between || std::isspace(static_cast<unsigned char>(c)) == 0;
      ++i;
    }
  }
  messages.pop_back();
  return messages;
}

/// Marks the letters of words in plain language; numbers, paths, keys and the like are values.
std::vector<int> LettersOfWords(const std::string& quote) {
  static const std::regex kWord(R"((^|[ (\x02])([A-Za-z]+)(?=[,:;.)]?([ \x02]|$)))");
  std::vector<int> marks(quote.size(), 0);
  for (std::sregex_iterator word(quote.begin(), quote.end(), kWord), end; word != end; ++word)
    std::fill_n(marks.begin() + word->position(2), word->length(2), 1);
  return marks;
}

/// Returns how many marked characters of the quote are fixed text of the message, if the quote is a part of the message
/// with some values; otherwise -1.
int FixedText(const std::string& quote, const std::vector<int>& marks, const Message& message) {
  constexpr int kNone = -1000000;
  // best[j]: of the quote up to now, after the first j characters of the message.
  std::vector<int> best(message.size() + 1, 0), next(message.size() + 1);
  for (size_t i = 0; i < quote.size(); ++i) {
    const char c = quote[i];
    std::fill(next.begin(), next.end(), kNone);
    if (c == kGap) {
      for (size_t j = 0; j < message.size(); ++j) best[j + 1] = std::max(best[j + 1], best[j]);
      continue;
    }
    for (size_t j = 0; j < message.size(); ++j) {
      if (message[j] == kValue) {
        // The value has another character, or ends before it.
        next[j] = std::max(next[j], best[j]);
        best[j + 1] = std::max(best[j + 1], best[j]);
      } else if (message[j] == c) {
        next[j + 1] = std::max(next[j + 1], best[j] + marks[i]);
      }
    }
    best.swap(next);
  }
  const int most = *std::max_element(best.begin(), best.end());
  return most < 0 ? -1 : most;
}

std::vector<std::string> Words(const std::string& text) {
  static const std::regex kWord(R"([A-Za-z]{4,})");
  return {std::sregex_token_iterator(text.begin(), text.end(), kWord), {}};
}

bool IsOneMessage(const std::string& quote, const std::vector<Message>& messages) {
  const std::vector<std::string> words = Words(quote);
  const std::vector<int> marks = LettersOfWords(quote);
  const auto n_letters = static_cast<double>(std::ranges::count(marks, 1));
  return std::ranges::any_of(messages, [&](const Message& message) {
    const auto n = std::ranges::count_if(
        words, [&](const std::string& word) { return message.find(word) != std::string::npos; });
    if (3 * n < static_cast<std::ptrdiff_t>(words.size())) return false;
    return FixedText(quote, marks, message) >= kFixedShare * n_letters;
  });
}

/// A quote is a part of one message, or of two, one after the other.
bool IsPrinted(const std::string& text, const std::vector<Message>& messages) {
  static const std::regex kDots(R"(\.\.\.)");
  std::string quote = text;
  for (const std::string value : kValuesOfWords) {
    if (const size_t at = quote.find(value); at != std::string::npos) quote.replace(at, value.size(), "0");
  }
  quote = std::regex_replace(quote, kDots, std::string(1, kGap));
  if (IsOneMessage(quote, messages)) return true;
  for (size_t at = quote.find(' '); at != std::string::npos; at = quote.find(' ', at + 1)) {
    const std::string first = quote.substr(0, at), second = quote.substr(at + 1);
    if (first.find(' ') == std::string::npos || second.find(' ') == std::string::npos) continue;
    if (IsOneMessage(first, messages) && IsOneMessage(second, messages)) return true;
  }
  return false;
}

/// Code between bold marks at the begin of the entries of a document.
std::set<std::string> QuotedIn(const std::string& document) {
  static const std::regex kEntry(R"(\n\* (\*\*[^\n]*(?:\n  [^\n]*)?))");
  std::set<std::string> quotes;
  for (std::sregex_iterator entry(document.begin(), document.end(), kEntry), end; entry != end; ++entry) {
    const std::string text = (*entry)[1];
    bool bold = false, code = false;
    std::string quote;
    for (size_t i = 0; i < text.size(); ++i) {
      if (!code && text.compare(i, 2, "**") == 0) {
        bold = !bold;
        ++i;
      } else if (text[i] == '`') {
        if (code && bold) quotes.insert(quote);
        code = !code;
        quote.clear();
      } else if (code) {
        quote += text[i] == '\n' ? ' ' : text[i];
      }
    }
  }
  return quotes;
}

/// Text of three words or more between double quotes, outside of code.
std::set<std::string> SentencesIn(const std::string& document) {
  static const std::regex kCode(R"(```[^]*?```|`[^`]*`)"), kQuote(R"re("([^"]*)")re"), kBlanks(R"(\s+)"),
      kWord("[A-Za-z]{2,}");
  const std::string prose = std::regex_replace(document, kCode, "code");
  std::set<std::string> sentences;
  for (std::sregex_iterator quote(prose.begin(), prose.end(), kQuote), end; quote != end; ++quote) {
    const std::string text = std::regex_replace((*quote)[1].str(), kBlanks, " ");
    if (std::distance(std::sregex_iterator(text.begin(), text.end(), kWord), end) >= 3) sentences.insert(text);
  }
  return sentences;
}

std::vector<Message> AllMessages() {
  std::vector<Message> messages;
  for (const test::SourceFile& file : test::AllSourceFiles()) {
    if (file.path.starts_with("tests/")) continue;
    for (Message& message : MessagesOf(file)) messages.push_back(std::move(message));
  }
  return messages;
}

TEST(QuotedMessages, FixedTextIsCompared) {
  const std::vector<Message> messages = MessagesOf(
      {"a.cpp",
       {"// \"a comment\"", "Fail(path + \": no process '{}' is heard \"", "  \"on {}\", c == '\"');", "F();"}});
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0], fmt::format("{0}: no process '{0}' is heard on {0}", kValue));
  EXPECT_TRUE(IsPrinted("no process 'mapping' is heard on udpm://", messages));
  EXPECT_TRUE(IsPrinted("process 'vo' is heard", messages));
  EXPECT_TRUE(IsPrinted("no process ... heard on udpm://", messages));
  EXPECT_FALSE(IsPrinted("no mapping_process is heard on udpm://", messages));
  EXPECT_FALSE(IsPrinted("no process 'mapping' was found on udpm://", messages));
  EXPECT_EQ(QuotedIn("x\n* **`a b`**, **c `d e`**: `f`\n* `g`\n* **h**: **`i`**\n"),
            (std::set<std::string>{"a b", "d e", "i"}));
  EXPECT_EQ(SentencesIn("x \"ab cd\n  ef\" `\"in code it is\"` \"two words\"\n```\n\"also in code\"\n```\n"),
            (std::set<std::string>{"ab cd ef"}));
}

TEST(QuotedMessages, TroubleshootingQuotesWhatIsPrinted) {
  const std::vector<Message> messages = AllMessages();
  const std::set<std::string> quotes = QuotedIn(test::ReadText(test::SourceFolder() / "docs" / "troubleshooting.md"));
  int n_compared = 0;
  for (const std::string& quote : quotes) {
    if (std::ranges::find(kForeign, quote) != kForeign.end() || quote.find(' ') == std::string::npos) continue;
    ++n_compared;
    EXPECT_TRUE(IsPrinted(quote, messages)) << "docs/troubleshooting.md quotes: " << quote;
  }
  EXPECT_GE(n_compared, 50);
}

TEST(QuotedMessages, AllPagesQuoteWhatIsPrinted) {
  const std::vector<Message> messages = AllMessages();
  int n_compared = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::SourceFolder() / "docs")) {
    if (!entry.is_regular_file() || entry.path().extension() != ".md") continue;
    // Written by scripts/results, without messages.
    if (entry.path().filename() == "results.md") continue;
    for (const std::string& quote : SentencesIn(test::ReadText(entry.path()))) {
      ++n_compared;
      EXPECT_TRUE(IsPrinted(quote, messages)) << entry.path() << " quotes: " << quote;
    }
  }
  EXPECT_GE(n_compared, 3);
}

}  // namespace
}  // namespace plslam
