#include "core/io/grey_png.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "core/io/png_filter.h"

namespace plslam {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr size_t kSignatureBytes = 8;
constexpr size_t kHeaderBytes = 13;

uint32_t BigEndian(const uint8_t* p) {
  return uint32_t{p[0]} << 24 | uint32_t{p[1]} << 16 | uint32_t{p[2]} << 8 | uint32_t{p[3]};
}

struct Chunk {
  std::string_view type;
  Bytes data;
  /// Lower case: a decoder may pass over it.
  bool Ancillary() const { return (type[0] & 0x20) != 0; }
};

/// Takes the chunk that `bytes` begin with. nullopt where it does not end in them, or its checksum is another.
std::optional<Chunk> NextChunk(Bytes& bytes) {
  constexpr size_t kFrame = 12;  // length and type before it, checksum behind it
  if (bytes.size() < kFrame || BigEndian(bytes.data()) > bytes.size() - kFrame) return std::nullopt;
  const size_t n = BigEndian(bytes.data());
  const uint8_t* const type = bytes.data() + 4;
  if (libdeflate_crc32(0, type, 4 + n) != BigEndian(type + 4 + n)) return std::nullopt;
  const Chunk chunk{{reinterpret_cast<const char*>(type), 4}, bytes.subspan(8, n)};
  bytes = bytes.subspan(kFrame + n);
  return chunk;
}

struct GreyHeader {
  int64_t width_px = 0;
  int64_t height_px = 0;
  size_t pixel_bytes = 1;
};

std::optional<GreyHeader> ParseHeader(const Chunk& chunk) {
  if (chunk.type != "IHDR" || chunk.data.size() != kHeaderBytes) return std::nullopt;
  const uint8_t* const p = chunk.data.data();
  const uint8_t bits = p[8];
  // Colour type, compression, filters and interlacing.
  constexpr std::array<uint8_t, 4> kGrey = {0, 0, 0, 0};
  if ((bits != 8 && bits != 16) || !std::equal(kGrey.begin(), kGrey.end(), p + 9)) return std::nullopt;
  return GreyHeader{BigEndian(p), BigEndian(p + 4), bits / size_t{8}};
}

/// The compressed pixels: those of all IDAT chunks, which must follow each other and end with IEND.
std::optional<std::vector<uint8_t>> Compressed(Bytes bytes) {
  std::vector<uint8_t> data;
  data.reserve(bytes.size());
  bool ended = false;
  while (const std::optional<Chunk> chunk = NextChunk(bytes)) {
    if (chunk->type == "IEND") return data;
    if (chunk->type == "IDAT" && !ended) {
      data.insert(data.end(), chunk->data.begin(), chunk->data.end());
    } else if (chunk->Ancillary()) {
      ended = !data.empty();
    } else {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

bool Decompress(const std::vector<uint8_t>& compressed, std::vector<uint8_t>& rows) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  return decompressor != nullptr &&
         libdeflate_zlib_decompress(decompressor.get(), compressed.data(), compressed.size(), rows.data(),
                                    rows.size(), nullptr) == LIBDEFLATE_SUCCESS;
}

cv::Mat ToImage(const GreyHeader& header, const std::vector<uint8_t>& rows) {
  cv::Mat image(static_cast<int>(header.height_px), static_cast<int>(header.width_px),
                header.pixel_bytes == 2 ? CV_16UC1 : CV_8UC1);
  const size_t row_bytes = static_cast<size_t>(header.width_px) * header.pixel_bytes;
  for (int y = 0; y < image.rows; ++y) {
    const uint8_t* const in = &rows[static_cast<size_t>(y) * (row_bytes + 1)] + 1;
    if (header.pixel_bytes == 1) {
      std::memcpy(image.ptr(y), in, row_bytes);
      continue;
    }
    auto* const out = image.ptr<uint16_t>(y);
    for (int x = 0; x < image.cols; ++x) out[x] = static_cast<uint16_t>(in[2 * x] << 8 | in[2 * x + 1]);
  }
  return image;
}

}  // namespace

std::optional<cv::Mat> DecodeGreyPng(Bytes bytes, int64_t max_pixels) {
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
  if (bytes.size() < kSignatureBytes || std::memcmp(bytes.data(), kSignature.data(), kSignatureBytes) != 0) {
    return std::nullopt;
  }
  bytes = bytes.subspan(kSignatureBytes);
  const std::optional<Chunk> first = NextChunk(bytes);
  const std::optional<GreyHeader> header = first ? ParseHeader(*first) : std::nullopt;
  if (!header || header->width_px < 1 || header->height_px < 1 || header->width_px > max_pixels / header->height_px) {
    return std::nullopt;
  }
  const std::optional<std::vector<uint8_t>> compressed = Compressed(bytes);
  const size_t row_bytes = static_cast<size_t>(header->width_px) * header->pixel_bytes;
  std::vector<uint8_t> rows(static_cast<size_t>(header->height_px) * (row_bytes + 1));
  const bool ok = compressed && Decompress(*compressed, rows) &&
                  UndoPngFilters(rows, static_cast<size_t>(header->height_px), row_bytes, header->pixel_bytes);
  return ok ? std::optional(ToImage(*header, rows)) : std::nullopt;
}

}  // namespace plslam
