// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/zstd_frames.h"

#include <fcntl.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "core/datasets/recordings/chunks.h"
#include "core/errors/error_text.h"

namespace plslam {
namespace {

constexpr std::array<uint8_t, 4> kMagic{0x28, 0xb5, 0x2f, 0xfd};

/// Writes the content of `file` to this descriptor.
void Unzstd(const RecordingFile& file, int to) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  std::vector<uint8_t> out(ZSTD_DStreamOutSize());
  const uint64_t most = kMostCompression * file.size() + kMaxChunkBytes;
  uint64_t written = 0;
  size_t expected = 1;  // 0: a frame is complete
  for (uint64_t at = 0; at < file.size();) {
    const uint64_t n = std::min<uint64_t>(ZSTD_DStreamInSize(), file.size() - at);
    const std::vector<uint8_t> bytes = file.ReadAt(at, n, "compressed data");
    at += n;
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    for (bool is_full = false; in.pos < in.size || is_full;) {
      ZSTD_outBuffer part{out.data(), out.size(), 0};
      expected = ZSTD_decompressStream(context.get(), &part, &in);
      if (ZSTD_isError(expected) != 0) {
        throw DatasetError(fmt::format("is damaged: zstd reports '{}'", ZSTD_getErrorName(expected)));
      }
      is_full = part.pos == part.size;
      written += part.pos;
      if (written > most) throw DatasetError(fmt::format("would have more than {} bytes: it is damaged", most));
      for (size_t done = 0; done < part.pos;) {
        const ssize_t n_written = write(to, out.data() + done, part.pos - done);
        if (n_written < 0 && errno == EINTR) continue;
        if (n_written <= 0) {
          throw DatasetError(fmt::format("cannot be decompressed into {}: {}; set TMPDIR to a folder with more room",
                                         std::filesystem::temp_directory_path().string(), ReasonOf(errno)));
        }
        done += static_cast<size_t>(n_written);
      }
    }
  }
  if (expected != 0) throw DatasetError("is truncated: its last zstd frame has no end");
}

}  // namespace

bool IsZstd(std::span<const uint8_t> bytes) {
  return bytes.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

std::vector<uint8_t> UnzstdMessage(std::span<const uint8_t> frame) {
  const auto n = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (n == ZSTD_CONTENTSIZE_ERROR) throw DatasetError("a message compressed by zstd is damaged");
  if (n != ZSTD_CONTENTSIZE_UNKNOWN) return DecompressChunk("zstd", frame, n);
  // A writer that compressed a stream did not know the length.
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  std::vector<uint8_t> part(ZSTD_DStreamOutSize()), content;
  ZSTD_inBuffer in{frame.data(), frame.size(), 0};
  for (size_t left = 1; left != 0;) {
    ZSTD_outBuffer out{part.data(), part.size(), 0};
    left = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(left) != 0 || (left != 0 && in.pos == in.size && out.pos == 0)) {
      throw DatasetError("a message compressed by zstd is damaged");
    }
    CheckChunkSize(content.size() + out.pos);
    content.insert(content.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(out.pos));
  }
  return content;
}

UnzstdFile::UnzstdFile(const std::string& path)
    : path_((std::filesystem::temp_directory_path() / "plslam-bag-XXXXXX").string()) {
  const RecordingFile file(path);
  const int to = mkostemp(path_.data(), O_CLOEXEC);
  if (to < 0) throw DatasetError(fmt::format("cannot be decompressed into {}: {}", path_, ReasonOf(errno)));
  try {
    Unzstd(file, to);
  } catch (const std::exception&) {
    close(to);
    unlink(path_.c_str());
    throw;
  }
  close(to);
}

UnzstdFile::~UnzstdFile() { unlink(path_.c_str()); }

}  // namespace plslam
