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

#include "core/files/atomic_file.h"

namespace plslam {

/// Checksum of the fields and the content: BLAKE2b for files that are kept; Poly1305 with a public key for files that
/// are written all the time: it takes a seventh of the time and detects damage as well.
enum class Checksum { kBlake2b, kPoly1305 };

/// A type of sealed file: its first bytes, the newest format that this program reads, and its name in sentences.
struct FileKind {
  std::array<char, 8> magic{};
  uint64_t format = 1;
  std::string_view name;  ///< "map file"
  Checksum checksum = Checksum::kBlake2b;
  uint64_t oldest_format = format;  ///< that this program reads
};

/// The head of a sealed file; `length` bytes of content follow.
struct Seal {
  std::array<char, 8> magic{};
  uint64_t format = 0;
  uint64_t length = 0;
  /// Checksum of the fields above and the content.
  std::array<uint8_t, 32> checksum{};
};
static_assert(sizeof(Seal) == 56);

/// The checksum of a seal whose content is added piece by piece.
class SealSum {
 public:
  SealSum(const FileKind& kind, const Seal& seal);
  void Add(std::span<const uint8_t> content);
  decltype(Seal::checksum) Take();

 private:
  std::variant<crypto_generichash_state, crypto_onetimeauth_state> state_;
};

/// Returns the seal of a content, to be written before it.
Seal MakeSeal(const FileKind& kind, std::span<const uint8_t> content);

/// Returns the seal at the beginning of `bytes`. Throws std::runtime_error, in a sentence without its subject, if it is
/// not of this type or of an unknown format.
Seal CheckKind(const FileKind& kind, std::span<const uint8_t> bytes);

/// Returns the seal at the beginning of a file of `file_length` bytes. Throws std::runtime_error, in a sentence without
/// its subject, if it is no such file, of another format, or not of that length.
Seal ReadSeal(const FileKind& kind, std::span<const uint8_t> bytes, uint64_t file_length);

/// Throws std::runtime_error if the content does not match the seal.
void CheckSeal(const FileKind& kind, const Seal& seal, std::span<const uint8_t> content);

/// A file of this type whose seal has been checked: content can be read only if it is valid. Throws std::runtime_error,
/// in a sentence without its subject.
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

/// Returns the result of `f`; the file's path is prepended to its std::runtime_errors.
template <class Function>
auto NamingFile(const std::string& path, Function f) {
  try {
    return f();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

/// Takes sealed content of this type from the front of `bytes`, which may continue with anything; nullopt if there is
/// none, or it is truncated or damaged.
std::optional<std::span<const uint8_t>> TakeSealed(const FileKind& kind, std::span<const uint8_t>& bytes);

/// Writes a sealed file whose content of `length` bytes is appended piece by piece; on completion it replaces `path`.
/// Throws std::runtime_error that names the file, and std::logic_error if the number of bytes differs.
class SealedFileWriter {
 public:
  SealedFileWriter(const std::string& path, const FileKind& kind, uint64_t length);
  void Append(std::span<const uint8_t> content);
  /// `survives_power_cut`: see `AtomicFile::Sync`.
  void PutInPlace(bool survives_power_cut = false);

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
