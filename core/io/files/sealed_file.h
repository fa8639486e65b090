// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <fstream>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <sodium.h>

#include "core/io/files/atomic_file.h"

namespace plslam {

/// Of fields and content: BLAKE2b for files that are kept; Poly1305 with a key that everybody knows for those that
/// are written all the time, which takes a seventh of that and sees damage as well.
enum class Checksum { kBlake2b, kPoly1305 };

/// A kind of file of ours: what it begins with, the format that this program knows, and what to call it.
struct FileKind {
  std::array<char, 8> magic{};
  uint64_t format = 1;
  std::string_view name;  ///< "map file"
  Checksum checksum = Checksum::kBlake2b;
  uint64_t oldest_format = format;  ///< that this program reads
};

/// What such a file begins with; then come `length` bytes of content.
struct Seal {
  std::array<char, 8> magic{};
  uint64_t format = 0;
  uint64_t length = 0;
  /// Of the fields above and the content.
  std::array<uint8_t, 32> checksum{};
};
static_assert(sizeof(Seal) == 56);

/// The checksum of a seal whose content comes piece by piece.
class SealSum {
 public:
  SealSum(const FileKind& kind, const Seal& seal);
  void Add(std::span<const uint8_t> content);
  decltype(Seal::checksum) Take();

 private:
  std::variant<crypto_generichash_state, crypto_onetimeauth_state> state_;
};

/// Of a content that belongs behind it.
Seal MakeSeal(const FileKind& kind, std::span<const uint8_t> content);

/// The seal that bytes begin with. Throws std::runtime_error, in a sentence without its subject, where it is none of
/// that kind and of a format that is known.
Seal CheckKind(const FileKind& kind, std::span<const uint8_t> bytes);

/// The seal at the beginning of a file of `file_length` bytes. Throws std::runtime_error, in a sentence without its
/// subject, where it is no such file, of another format, or not of that length.
Seal ReadSeal(const FileKind& kind, std::span<const uint8_t> bytes, uint64_t file_length);

/// Throws std::runtime_error where the content is not what was sealed.
void CheckSeal(const FileKind& kind, const Seal& seal, std::span<const uint8_t> content);

/// A file of that kind, of which the seal has been read: content is asked for only where it is one. Throws
/// std::runtime_error, in a sentence without its subject.
class SealedFileReader {
 public:
  SealedFileReader(const std::string& path, const FileKind& kind);

  const Seal& seal() const { return seal_; }
  /// `seal().length` bytes, not checked yet (CheckSeal).
  void Read(uint8_t* content);

 private:
  std::ifstream file_;
  Seal seal_;
};

/// What `f` gives; its std::runtime_errors get the file in front.
template <class Function>
auto NamingFile(const std::string& path, Function f) {
  try {
    return f();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

/// The content that begins with a seal of that kind, taken from the front of `bytes`, in which anything may follow;
/// nullopt where there is none, or it is cut off or damaged.
std::optional<std::span<const uint8_t>> TakeSealed(const FileKind& kind, std::span<const uint8_t>& bytes);

/// Such a file whose content comes piece by piece, `length` bytes of it, and which then takes the place of `path`.
/// Throws std::runtime_error that names the file, and std::logic_error where another number of bytes came.
class SealedFileWriter {
 public:
  SealedFileWriter(const std::string& path, const FileKind& kind, uint64_t length);
  void Append(std::span<const uint8_t> content);
  void PutInPlace();

 private:
  AtomicFile file_;
  uint64_t length_ = 0;
  Seal seal_;
  SealSum sum_;
};

/// Beside the file and renamed. Throws std::runtime_error that names the file.
void WriteSealedFile(const std::string& path, const FileKind& kind, std::span<const uint8_t> content);

/// The content. Throws std::runtime_error that names the file.
std::vector<uint8_t> ReadSealedFile(const std::string& path, const FileKind& kind);

}  // namespace plslam
