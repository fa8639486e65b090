// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/png_grey.h"

#include <libdeflate.h>

#include <array>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "core/io/images/png_filters.h"

namespace plslam {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
/// Length, name and checksum of a chunk; the contents are between the last two.
constexpr size_t kChunkFrame = 12;
constexpr size_t kHeaderSize = 13;

uint32_t BigEndian(const uint8_t* bytes) {
  return uint32_t{bytes[0]} << 24 | uint32_t{bytes[1]} << 16 | uint32_t{bytes[2]} << 8 | uint32_t{bytes[3]};
}

struct Chunk {
  std::string_view name;
  std::span<const uint8_t> contents;
};

/// The first chunk, which is taken off `rest`; nullopt where it is cut off or not what was written.
std::optional<Chunk> TakeChunk(std::span<const uint8_t>& rest) {
  if (rest.size() < kChunkFrame) return std::nullopt;
  const size_t size = BigEndian(rest.data());
  if (size > rest.size() - kChunkFrame) return std::nullopt;
  const uint8_t* name = rest.data() + 4;
  if (libdeflate_crc32(0, name, size + 4) != BigEndian(name + 4 + size)) return std::nullopt;
  const Chunk chunk{{reinterpret_cast<const char*>(name), 4}, rest.subspan(8, size)};
  rest = rest.subspan(size + kChunkFrame);
  return chunk;
}

bool IsPlainGrey(const Chunk& header, cv::Size size) {
  // Bits, colour type, compression, filters, interlacing.
  constexpr std::array<uint8_t, 5> kPlainGrey = {8, 0, 0, 0, 0};
  return header.name == "IHDR" && header.contents.size() == kHeaderSize &&
         BigEndian(header.contents.data()) == static_cast<uint32_t>(size.width) &&
         BigEndian(header.contents.data() + 4) == static_cast<uint32_t>(size.height) &&
         std::memcmp(header.contents.data() + 8, kPlainGrey.data(), kPlainGrey.size()) == 0;
}

/// Of another program's that may be passed over, and does not change pixels as transparency does.
bool IsBeside(const Chunk& chunk) {
  constexpr char kAncillary = 0x20;
  return (chunk.name[0] & kAncillary) != 0 && chunk.name != "tRNS";
}

/// The compressed pixels, which lie in one chunk after the other; nullopt where the file is another or damaged.
std::optional<std::vector<uint8_t>> CompressedPixels(std::span<const uint8_t> file, cv::Size size) {
  if (file.size() < kSignature.size() || std::memcmp(file.data(), kSignature.data(), kSignature.size()) != 0) {
    return std::nullopt;
  }
  std::span<const uint8_t> rest = file.subspan(kSignature.size());
  const std::optional<Chunk> header = TakeChunk(rest);
  if (!header || !IsPlainGrey(*header, size)) return std::nullopt;
  std::vector<uint8_t> pixels;
  pixels.reserve(rest.size());
  bool is_behind = false;
  while (const std::optional<Chunk> chunk = TakeChunk(rest)) {
    if (chunk->name == "IEND") return pixels;
    if (chunk->name == "IDAT" && !is_behind) {
      pixels.insert(pixels.end(), chunk->contents.begin(), chunk->contents.end());
    } else if (IsBeside(*chunk)) {
      is_behind = !pixels.empty();
    } else {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<cv::Mat> DecodeGreyPng(std::span<const uint8_t> file, cv::Size size) {
  const std::optional<std::vector<uint8_t>> compressed = CompressedPixels(file, size);
  if (!compressed) return std::nullopt;
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!decompressor) return std::nullopt;
  const size_t filtered_size = (static_cast<size_t>(size.width) + 1) * static_cast<size_t>(size.height);
  const auto filtered = std::make_unique_for_overwrite<uint8_t[]>(filtered_size);
  // Without a place for the size that comes out, no other size is a success.
  const libdeflate_result result = libdeflate_zlib_decompress(
      decompressor.get(), compressed->data(), compressed->size(), filtered.get(), filtered_size, nullptr);
  cv::Mat image(size, CV_8UC1);
  if (result != LIBDEFLATE_SUCCESS || !TakeFiltersOff(filtered.get(), image)) return std::nullopt;
  return image;
}

}  // namespace plslam
