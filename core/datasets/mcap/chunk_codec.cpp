// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/mcap/chunk_codec.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <memory>

#include "core/errors/error_text.h"
#include "core/io/files/dataset_error.h"

namespace plslam {
namespace {

constexpr uint64_t kMaxChunkBytes = 128 << 20;

[[noreturn]] void FailAsDamaged(const char* compression, const char* why) {
  throw DatasetError(fmt::format("a chunk is damaged: {} says '{}'", compression, why));
}

uint64_t Unzstd(std::span<const uint8_t> in, std::vector<uint8_t>& out) {
  const size_t n = ZSTD_decompress(out.data(), out.size(), in.data(), in.size());
  if (ZSTD_isError(n) != 0) FailAsDamaged("zstd", ZSTD_getErrorName(n));
  return n;
}

uint64_t Unlz4(std::span<const uint8_t> in, std::vector<uint8_t>& out) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0U) FailAsDamaged("lz4", "no memory");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(made,
                                                                                     LZ4F_freeDecompressionContext);
  size_t in_done = 0, out_done = 0;
  while (in_done < in.size()) {
    size_t in_bytes = in.size() - in_done, out_bytes = out.size() - out_done;
    const size_t result =
        LZ4F_decompress(context.get(), out.data() + out_done, &out_bytes, in.data() + in_done, &in_bytes, nullptr);
    if (LZ4F_isError(result) != 0U) FailAsDamaged("lz4", LZ4F_getErrorName(result));
    in_done += in_bytes;
    out_done += out_bytes;
    if (in_bytes == 0 && out_bytes == 0) FailAsDamaged("lz4", "more bytes than the chunk should have");
  }
  return out_done;
}

}  // namespace

std::vector<uint8_t> DecompressChunk(const std::string& compression, std::span<const uint8_t> bytes, uint64_t n) {
  if (n > kMaxChunkBytes) {
    throw DatasetError(
        fmt::format("a chunk of {} bytes, more than {}: `mcap compress` writes smaller ones", n, kMaxChunkBytes));
  }
  if (compression.empty()) {
    if (n != bytes.size()) FailAsDamaged("the file", "another length");
    return {bytes.begin(), bytes.end()};
  }
  if (compression != "lz4" && compression != "zstd") {
    throw DatasetError(fmt::format("its chunks are compressed by '{}', not by lz4 or zstd", Shown(compression)));
  }
  auto out = WithMemoryFor(fmt::format("a chunk of {} bytes", n), [&] { return std::vector<uint8_t>(n); });
  const uint64_t got = compression == "lz4" ? Unlz4(bytes, out) : Unzstd(bytes, out);
  if (got != n) FailAsDamaged(compression.c_str(), "another length");
  return out;
}

}  // namespace plslam
