// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fuzz/dataset_mutator.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace plslam::test {
namespace {

constexpr std::array<std::string_view, 24> kNumbers = {"nan",
                                                       "inf",
                                                       "-inf",
                                                       "1e308",
                                                       "-1e308",
                                                       "1e-320",
                                                       "1e99999",
                                                       "-1",
                                                       "0",
                                                       "-0",
                                                       "1",
                                                       "9223372036854775807",
                                                       "9223372036854775808",
                                                       "-9223372036854775808",
                                                       "4294967296",
                                                       "65536",
                                                       "1e18",
                                                       "0x10",
                                                       "",
                                                       ".",
                                                       "-",
                                                       "1.2.3",
                                                       "999999999999999999999999999999999999999999999999999999",
                                                       "0.00000000000000000000000000000000000001"};

constexpr std::array<uint32_t, 12> kSizes = {0,     1,     2,    47,         49,         640,
                                             65535, 65536, 8192, 0x7fffffff, 0x80000000, 0xffffffff};

// Checksum of PNG (polynomial 0xedb88320, reflected).
uint32_t Crc32(std::string_view bytes) {
  uint32_t crc = 0xffffffff;
  for (const char c : bytes) {
    crc ^= static_cast<uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320 : 0);
  }
  return ~crc;
}

void PutBigEndian(std::string& bytes, size_t at, uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes[at + static_cast<size_t>(i)] = static_cast<char>(value >> (24 - 8 * i));
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  size_t at = 0;
  while (at < text.size()) {
    const size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    lines.push_back(text.substr(at, end - at));
    at = end;
  }
  return lines;
}

bool IsNumberPart(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e'; }

}  // namespace

int DatasetMutator::Below(int n) { return static_cast<int>(random_() % static_cast<uint64_t>(std::max(n, 1))); }

std::string DatasetMutator::Mutate(std::string bytes, std::string_view other) {
  for (int n = 1 + Below(3); n > 0; --n) MutateOnce(bytes, other);
  return bytes;
}

void DatasetMutator::MutateOnce(std::string& bytes, std::string_view other) {
  switch (Below(12)) {
    case 0:
      bytes.resize(static_cast<size_t>(Below(static_cast<int>(bytes.size()))));
      return;
    case 1:
      if (Below(4) == 0) bytes = other;
      return;
    case 2:
    case 3:
      FlipBytes(bytes);
      return;
    case 4:
      Splice(bytes);
      return;
    case 5:
    case 6:
      ResizePng(bytes);
      return;
    case 7:
    case 8:
      ChangeLines(bytes);
      return;
    default:
      ReplaceNumber(bytes);
  }
}

void DatasetMutator::FlipBytes(std::string& bytes) {
  if (bytes.empty()) return;
  for (int n = 1 + Below(4); n > 0; --n) {
    bytes[static_cast<size_t>(Below(static_cast<int>(bytes.size())))] = static_cast<char>(Below(256));
  }
}

void DatasetMutator::Splice(std::string& bytes) {
  const auto at = static_cast<size_t>(Below(static_cast<int>(bytes.size()) + 1));
  if (Below(2) == 0) {
    bytes.erase(at, static_cast<size_t>(Below(40)));
  } else {
    bytes.insert(at, static_cast<size_t>(Below(5000)), static_cast<char>(Below(256)));
  }
}

void DatasetMutator::ReplaceNumber(std::string& bytes) {
  const auto from = static_cast<size_t>(Below(static_cast<int>(bytes.size()) + 1));
  const auto first = static_cast<size_t>(
      std::find_if(bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.end(), IsNumberPart) - bytes.begin());
  const auto last = static_cast<size_t>(
      std::find_if_not(bytes.begin() + static_cast<std::ptrdiff_t>(first), bytes.end(), IsNumberPart) -
      bytes.begin());
  bytes.replace(first, last - first, kNumbers[static_cast<size_t>(Below(static_cast<int>(kNumbers.size())))]);
}

void DatasetMutator::ChangeLines(std::string& bytes) {
  std::vector<std::string> lines = Lines(bytes);
  if (lines.empty()) return;
  const auto a = static_cast<size_t>(Below(static_cast<int>(lines.size())));
  const auto b = static_cast<size_t>(Below(static_cast<int>(lines.size())));
  const int choice = Below(3);
  if (choice == 0) lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(a));
  if (choice == 1) lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(b), std::string(lines[a]));
  if (choice == 2) std::swap(lines[a], lines[b]);
  bytes.clear();
  for (const std::string& line : lines) bytes += line;
}

void DatasetMutator::ResizePng(std::string& bytes) {
  constexpr size_t kHeader = 12;
  constexpr size_t kHeaderEnd = 29;
  if (bytes.size() < kHeaderEnd + 4 || bytes.compare(1, 3, "PNG") != 0) {
    ReplaceNumber(bytes);
    return;
  }
  const auto size = [this] { return kSizes[static_cast<size_t>(Below(static_cast<int>(kSizes.size())))]; };
  if (Below(2) == 0) PutBigEndian(bytes, 16, size());
  if (Below(2) == 0) PutBigEndian(bytes, 20, size());
  if (Below(2) == 0) bytes[24 + static_cast<size_t>(Below(5))] = static_cast<char>(Below(17));
  PutBigEndian(bytes, kHeaderEnd, Crc32(std::string_view(bytes).substr(kHeader, kHeaderEnd - kHeader)));
}

}  // namespace plslam::test
