// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/image_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

namespace plslam {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr std::array<uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr size_t kPngChunkFrame = 12;  // length, type, checksum
// Cameras append padding and thumbnails after EOI, but not much.
constexpr size_t kJpegTail = 4096;

uint32_t BigEndian(Bytes bytes, size_t at, int n) {
  uint32_t value = 0;
  for (int i = 0; i < n; ++i) value = (value << 8) | bytes[at + static_cast<size_t>(i)];
  return value;
}

bool HasText(Bytes bytes, size_t at, std::string_view text) {
  return at + text.size() <= bytes.size() && std::memcmp(bytes.data() + at, text.data(), text.size()) == 0;
}

bool IsPng(Bytes bytes) {
  return bytes.size() >= 8 && std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin());
}

std::optional<ImageHeader> ParsePng(Bytes bytes) {
  if (bytes.size() < 33 || !HasText(bytes, 12, "IHDR")) return std::nullopt;
  return ImageHeader{ImageFormat::kPng, BigEndian(bytes, 16, 4), BigEndian(bytes, 20, 4), 0, 0, bytes[24]};
}

bool IsPngComplete(Bytes bytes) {
  size_t at = kPngSignature.size();
  while (at + kPngChunkFrame <= bytes.size()) {
    const size_t end = at + kPngChunkFrame + BigEndian(bytes, at, 4);
    if (end > bytes.size()) return false;
    if (HasText(bytes, at + 4, "IEND")) return true;
    at = end;
  }
  return false;
}

// Start-of-frame markers C0..CF, without the tables and the extension that share the range.
bool IsFrameMarker(uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

std::optional<ImageHeader> ParseJpeg(Bytes bytes) {
  size_t at = 2;
  while (at + 4 <= bytes.size()) {
    if (bytes[at] != 0xff) return std::nullopt;
    const uint8_t marker = bytes[at + 1];
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    if (IsFrameMarker(marker)) {
      if (at + 9 > bytes.size()) return std::nullopt;
      return ImageHeader{ImageFormat::kJpeg, BigEndian(bytes, at + 7, 2), BigEndian(bytes, at + 5, 2), 0, 0, 8};
    }
    at += 2 + BigEndian(bytes, at + 2, 2);
  }
  return std::nullopt;
}

bool IsJpegComplete(Bytes bytes) {
  const Bytes tail = bytes.subspan(bytes.size() - std::min(bytes.size(), kJpegTail));
  for (size_t i = tail.size(); i >= 2; --i) {
    if (tail[i - 2] == 0xff && tail[i - 1] == 0xd9) return true;
  }
  return false;
}

bool IsBlank(uint8_t c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// Reads a number of a PGM header, and the byte after it; comments extend from # to the end of the line.
std::optional<int64_t> PgmNumber(Bytes bytes, size_t& at) {
  while (at < bytes.size() && (IsBlank(bytes[at]) || bytes[at] == '#')) {
    if (bytes[at] == '#') {
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    } else {
      ++at;
    }
  }
  int64_t value = 0;
  const size_t first = at;
  for (; at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9' && at < first + 9; ++at) {
    value = 10 * value + (bytes[at] - '0');
  }
  if (at == first || at >= bytes.size() || !IsBlank(bytes[at])) return std::nullopt;
  ++at;
  return value;
}

std::optional<ImageHeader> ParsePgm(Bytes bytes) {
  size_t at = 2;
  const std::optional<int64_t> width = PgmNumber(bytes, at);
  const std::optional<int64_t> height = width ? PgmNumber(bytes, at) : std::nullopt;
  const std::optional<int64_t> max_value = height ? PgmNumber(bytes, at) : std::nullopt;
  if (!max_value || *max_value < 1 || *max_value > 65535) return std::nullopt;
  return ImageHeader{ImageFormat::kPgm, *width, *height, static_cast<int>(*max_value), at, *max_value > 255 ? 16 : 8};
}

bool IsPgmComplete(const ImageHeader& header, Bytes bytes) {
  const int64_t bytes_per_pixel = header.max_value > 255 ? 2 : 1;
  const auto size = static_cast<int64_t>(bytes.size() - header.data_offset);
  return size >= header.width_px * header.height_px * bytes_per_pixel;
}

}  // namespace

std::optional<ImageHeader> ParseImageHeader(Bytes bytes) {
  if (IsPng(bytes)) return ParsePng(bytes);
  if (bytes.size() >= 2 && bytes[0] == 0xff && bytes[1] == 0xd8) return ParseJpeg(bytes);
  if (HasText(bytes, 0, "P5")) return ParsePgm(bytes);
  return std::nullopt;
}

bool IsComplete(const ImageHeader& header, Bytes bytes) {
  switch (header.format) {
    case ImageFormat::kPng:
      return IsPngComplete(bytes);
    case ImageFormat::kJpeg:
      return IsJpegComplete(bytes);
    case ImageFormat::kPgm:
      return IsPgmComplete(header, bytes);
  }
  return false;
}

}  // namespace plslam
