// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/rejections.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

constexpr int64_t kShown = 60'000'000'000;
constexpr size_t kMaxPrefixes = 4;
constexpr size_t kMaxPrefixBytes = 32;

/// Names from the wire go to terminals.
std::string Plain(std::string_view text) {
  std::string plain(text.substr(0, kMaxPrefixBytes));
  std::replace_if(
      plain.begin(), plain.end(), [](unsigned char c) { return c < 0x20 || c > 0x7e || c == '\''; }, '?');
  return plain;
}

}  // namespace

std::string_view Rejections::Text(Rejection why) {
  switch (why) {
    case Rejection::kMalformed:
      return "malformed";
    case Rejection::kOversized:
      return "too large";
    case Rejection::kOtherVersion:
      return "of another version";
    case Rejection::kOtherSchema:
      return "of another schema";
    case Rejection::kNoKey:
      return "without bus.key_file";
    case Rejection::kOtherKey:
      return "altered or with another bus.key_file";
    case Rejection::kReplayed:
      return "replayed";
    case Rejection::kNumber:
      break;
  }
  return "";
}

std::string Rejections::PrefixText(std::string_view prefix) {
  return fmt::format("processes with prefix '{}' were found, too", Plain(prefix));
}

bool Rejections::Count(Rejection why, std::string_view channel, int64_t now) {
  const std::scoped_lock lock(mutex_);
  Row& row = rows_[static_cast<size_t>(why)];
  row.last = now;
  if (row.channel != channel) row.channel = channel;
  return ++row.count == 1;
}

bool Rejections::OtherPrefix(std::string_view prefix, int64_t now) {
  const std::string plain = Plain(prefix);
  const std::scoped_lock lock(mutex_);
  const auto found = prefixes_.find(plain);
  if (found != prefixes_.end()) {
    found->second = now;
    return false;
  }
  std::erase_if(prefixes_, [&](const auto& entry) { return now - entry.second > kShown; });
  if (prefixes_.size() >= kMaxPrefixes) return false;
  prefixes_[plain] = now;
  return true;
}

bool Rejections::IsRecent(const Row& row, int64_t now) { return row.count > 0 && now - row.last <= kShown; }

bool Rejections::Has(Rejection why, int64_t now) const {
  const std::scoped_lock lock(mutex_);
  return IsRecent(rows_[static_cast<size_t>(why)], now);
}

std::string Rejections::Line(int64_t now) const {
  std::string line;
  const auto add = [&](const std::string& text) { line += (line.empty() ? "messages rejected: " : ", ") + text; };
  const std::scoped_lock lock(mutex_);
  for (size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (!IsRecent(row, now)) continue;
    add(fmt::format("{} {} ({})", row.count, Text(static_cast<Rejection>(i)), row.channel));
  }
  for (const auto& [prefix, last] : prefixes_) {
    if (now - last <= kShown) line = Joined(line, PrefixText(prefix));
  }
  return line;
}

}  // namespace plslam::bus
