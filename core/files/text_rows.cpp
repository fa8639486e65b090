// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/text_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "core/errors/error_text.h"
#include "core/files/git_lfs.h"

namespace plslam {
namespace {

constexpr int kMaxLineLength = 4096;
constexpr int kMaxLines = 10'000'000;
constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view Trim(std::string_view text) {
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> SplitAtCommas(std::string_view text) {
  std::vector<std::string_view> fields;
  for (size_t end = text.find(','); end != std::string_view::npos; end = text.find(',')) {
    fields.push_back(Trim(text.substr(0, end)));
    text.remove_prefix(end + 1);
  }
  fields.push_back(Trim(text));
  return fields;
}

std::vector<std::string_view> SplitAtBlanks(std::string_view text) {
  std::vector<std::string_view> fields;
  while (!(text = Trim(text)).empty()) {
    const size_t end = std::min(text.find_first_of(kBlanks), text.size());
    fields.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return fields;
}

// A decimal number taken apart: (negative ? -1 : 1) * 0.DIGITS * 10^point.
struct Decimal {
  bool negative = false;
  std::string digits;
  int64_t point = 0;
};

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

bool ParseExponent(std::string_view text, int64_t& exponent) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  exponent = value;
  return error == std::errc() && end == text.data() + text.size() && std::abs(value) < 10000;
}

bool ParseDecimal(std::string_view text, Decimal& decimal) {
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) {
    decimal.negative = text[0] == '-';
    text.remove_prefix(1);
  }
  const size_t mantissa_end = std::min(text.find_first_of("eE"), text.size());
  bool after_point = false;
  for (const char c : text.substr(0, mantissa_end)) {
    if (c == '.' && !after_point) {
      after_point = true;
    } else if (IsDigit(c)) {
      decimal.digits.push_back(c);
      if (!after_point) ++decimal.point;
    } else {
      return false;
    }
  }
  if (decimal.digits.empty()) return false;
  if (mantissa_end == text.size()) return true;
  int64_t exponent = 0;
  if (!ParseExponent(text.substr(mantissa_end + 1), exponent)) return false;
  decimal.point += exponent;
  return true;
}

// Computes the value times 10^decimals, rounded half away from zero; false if it exceeds 64 bits.
bool ToInteger(const Decimal& decimal, int decimals, int64_t& value) {
  const int64_t n_digits = decimal.point + decimals;
  const auto digit = [&](int64_t i) {
    return i >= 0 && i < static_cast<int64_t>(decimal.digits.size()) ? decimal.digits[static_cast<size_t>(i)] - '0'
                                                                     : 0;
  };
  value = 0;
  for (int64_t i = 0; i < n_digits; ++i) {
    if (__builtin_mul_overflow(value, int64_t{10}, &value)) return false;
    if (__builtin_add_overflow(value, int64_t{digit(i)}, &value)) return false;
  }
  if (digit(n_digits) >= 5 && __builtin_add_overflow(value, int64_t{1}, &value)) return false;
  if (decimal.negative) value = -value;
  return true;
}

/// In which a moment of our century is a number of that many digits.
const char* UnitOfTime(const Decimal& decimal) {
  if (decimal.point >= 18) return "nanoseconds";
  return decimal.point >= 15 ? "microseconds" : "milliseconds";
}

std::string_view ReadLine(std::ifstream& file, const std::string& path, int line, std::vector<char>& buffer) {
  file.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
  if (file.bad()) throw std::runtime_error(fmt::format("{}:{}: the rest of the file cannot be read", path, line));
  if (file.fail() && !file.eof()) {
    throw std::runtime_error(fmt::format("{}:{}: the line has more than {} characters: '{}'", path, line,
                                         kMaxLineLength, Shown(buffer.data())));
  }
  const std::streamsize end_of_line = file.eof() ? 0 : 1;
  std::string_view text(buffer.data(), static_cast<size_t>(file.gcount() - end_of_line));
  if (text.find('\0') != std::string_view::npos) {
    throw std::runtime_error(fmt::format("{}:{}: is not text, but binary: '{}'", path, line, Shown(text)));
  }
  if (line == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return text;
}

}  // namespace

void TextRow::Fail(const std::string& message) const {
  throw std::runtime_error(fmt::format("{}:{}: {}", *path, line, message));
}

bool TextRow::IsCsvHeader() const {
  const std::string_view name = fields.front();
  return is_first && has_commas && !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0;
}

double TextRow::Number(size_t field) const {
  std::string_view text = fields.at(field);
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  // Numbers too small for a double are zero for any purpose here.
  const bool underflow = error == std::errc::result_out_of_range && text.find('-', 1) != std::string_view::npos;
  if (underflow && end == text.data() + text.size()) return 0.0;
  const bool whole = error == std::errc() && end == text.data() + text.size() && !text.empty();
  if (!whole || !std::isfinite(value)) Fail(fmt::format("'{}' is not a finite number", Shown(fields[field])));
  return value;
}

int64_t TextRow::Scaled(size_t field, int decimals) const {
  Decimal decimal;
  if (!ParseDecimal(fields.at(field), decimal))
    Fail(fmt::format("'{}' is not a decimal number", Shown(fields[field])));
  int64_t value = 0;
  if (!ToInteger(decimal, decimals, value)) {
    Fail(fmt::format("'{}' is too large for a time in {}", Shown(fields[field]),
                     decimals == 9 ? fmt::format("seconds (is it in {}?)", UnitOfTime(decimal)) : "nanoseconds"));
  }
  return value;
}

void ForEachRow(const std::string& path, const std::function<void(const TextRow&)>& use) {
  std::ifstream file = OpenInput(path);
  std::vector<char> buffer(kMaxLineLength + 1);
  bool is_first = true;
  for (int line = 1; !file.eof(); ++line) {
    if (line > kMaxLines) throw std::runtime_error(path + ": has more than ten million lines");
    const std::string_view text = Trim(ReadLine(file, path, line, buffer));
    if (line == 1 && IsGitLfsPointer(text)) throw std::runtime_error(fmt::format("{}: {}", path, kGitLfsPointer));
    if (text.empty() || text[0] == '#') continue;
    const bool commas = text.find(',') != std::string_view::npos;
    use({&path, line, commas ? SplitAtCommas(text) : SplitAtBlanks(text), commas, is_first});
    is_first = false;
  }
}

}  // namespace plslam
