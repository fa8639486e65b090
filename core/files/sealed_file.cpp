// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/sealed_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "core/errors/error_text.h"

namespace plslam {
namespace {

constexpr size_t kSummed = 24;

using Sum = decltype(Seal::checksum);
using Bytes = std::span<const uint8_t>;

Sum SumOf(const FileKind& kind, const Seal& seal, Bytes content) {
  SealSum sum(kind, seal);
  sum.Add(content);
  return sum.Take();
}

std::string_view Text(const void* bytes, size_t n) { return {static_cast<const char*>(bytes), n}; }

void ReadExactly(std::ifstream& file, uint8_t* bytes, size_t n) {
  if (!file.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(n))) {
    throw std::runtime_error("cannot be read to its end");
  }
}

}  // namespace

SealSum::SealSum(const FileKind& kind, const Seal& seal) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
  if (kind.checksum == Checksum::kBlake2b) {
    crypto_generichash_init(&state_.emplace<crypto_generichash_state>(), nullptr, 0, sizeof(Sum));
  } else {
    static constexpr std::array<uint8_t, crypto_onetimeauth_KEYBYTES> kKey = {'n', 'o', ' ', 's', 'e',
                                                                              'c', 'r', 'e', 't'};
    crypto_onetimeauth_init(&state_.emplace<crypto_onetimeauth_state>(), kKey.data());
  }
  Add(Bytes(reinterpret_cast<const uint8_t*>(&seal), kSummed));
}

void SealSum::Add(Bytes content) {
  if (auto* blake = std::get_if<crypto_generichash_state>(&state_)) {
    crypto_generichash_update(blake, content.data(), content.size());
  } else {
    crypto_onetimeauth_update(&std::get<crypto_onetimeauth_state>(state_), content.data(), content.size());
  }
}

Sum SealSum::Take() {
  Sum sum{};
  if (auto* blake = std::get_if<crypto_generichash_state>(&state_)) {
    crypto_generichash_final(blake, sum.data(), sum.size());
  } else {
    static_assert(crypto_onetimeauth_BYTES <= sizeof(Sum));
    crypto_onetimeauth_final(&std::get<crypto_onetimeauth_state>(state_), sum.data());
  }
  return sum;
}

Seal MakeSeal(const FileKind& kind, std::span<const uint8_t> content) {
  Seal seal{kind.magic, kind.format, content.size(), {}};
  seal.checksum = SumOf(kind, seal, content);
  return seal;
}

Seal CheckKind(const FileKind& kind, std::span<const uint8_t> bytes) {
  Seal seal;
  if (bytes.size() < sizeof(Seal)) throw std::runtime_error(fmt::format("is not a {} (too short)", kind.name));
  std::memcpy(&seal, bytes.data(), sizeof(Seal));
  if (seal.magic != kind.magic) throw std::runtime_error(fmt::format("is not a {}", kind.name));
  if (seal.format < kind.oldest_format || seal.format > kind.format) {
    const bool one = kind.oldest_format == kind.format;
    throw std::runtime_error(fmt::format("is a {} of format {}, but this program reads {}", kind.name, seal.format,
                                         one ? fmt::format("format {}", kind.format)
                                             : fmt::format("formats {} to {}", kind.oldest_format, kind.format)));
  }
  return seal;
}

Seal ReadSeal(const FileKind& kind, std::span<const uint8_t> bytes, uint64_t file_length) {
  const Seal seal = CheckKind(kind, bytes);
  if (seal.length != file_length - sizeof(Seal)) {
    throw std::runtime_error(fmt::format("has {} bytes of content instead of {}: it was truncated or damaged",
                                         file_length - sizeof(Seal), seal.length));
  }
  return seal;
}

void CheckSeal(const FileKind& kind, const Seal& seal, std::span<const uint8_t> content) {
  if (SumOf(kind, seal, content) != seal.checksum) throw std::runtime_error("is damaged: its checksum is wrong");
}

SealedFileReader::SealedFileReader(const std::string& path, const FileKind& kind) {
  std::error_code error;
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) throw std::runtime_error(why);
  if (!std::filesystem::is_regular_file(path, error)) throw std::runtime_error("is not a regular file");
  file_.open(path, std::ios::binary | std::ios::ate);
  if (!file_) throw std::runtime_error("cannot be read: " + ReasonOf(errno));
  const auto length = static_cast<uint64_t>(file_.tellg());
  file_.seekg(0);
  std::array<uint8_t, sizeof(Seal)> head{};
  const size_t n = std::min<uint64_t>(length, sizeof(Seal));
  ReadExactly(file_, head.data(), n);
  seal_ = ReadSeal(kind, Bytes(head).first(n), length);
}

void SealedFileReader::Read(uint8_t* content) { ReadExactly(file_, content, seal_.length); }

std::optional<Bytes> TakeSealed(const FileKind& kind, Bytes& bytes) {
  Seal seal;
  if (bytes.size() < sizeof(Seal)) return std::nullopt;
  std::memcpy(&seal, bytes.data(), sizeof(Seal));
  if (seal.magic != kind.magic || seal.format != kind.format || seal.length > bytes.size() - sizeof(Seal))
    return std::nullopt;
  const Bytes content = bytes.subspan(sizeof(Seal), seal.length);
  if (SumOf(kind, seal, content) != seal.checksum) return std::nullopt;
  bytes = bytes.subspan(sizeof(Seal) + seal.length);
  return content;
}

SealedFileWriter::SealedFileWriter(const std::string& path, const FileKind& kind, uint64_t length)
    : file_(path), seal_{kind.magic, kind.format, length, {}}, sum_(kind, seal_) {
  file_.Append(Text(&seal_, sizeof(seal_)));
}

void SealedFileWriter::Append(Bytes content) {
  length_ += content.size();
  sum_.Add(content);
  file_.Append(Text(content.data(), content.size()));
}

void SealedFileWriter::PutInPlace(bool survives_power_cut) {
  if (length_ != seal_.length)
    throw std::logic_error(fmt::format("{} bytes of content instead of {}", length_, seal_.length));
  seal_.checksum = sum_.Take();
  file_.OverwriteBeginning(Text(&seal_, sizeof(seal_)));
  if (survives_power_cut) file_.Sync();
  file_.PutInPlace();
}

void WriteSealedFile(const std::string& path, const FileKind& kind, std::span<const uint8_t> content) {
  const Seal seal = MakeSeal(kind, content);
  WriteFileAtomically(path, {Text(&seal, sizeof(seal)), Text(content.data(), content.size())});
}

std::vector<uint8_t> ReadSealedFile(const std::string& path, const FileKind& kind) {
  return NamingFile(path, [&] {
    SealedFileReader file(path, kind);
    std::vector<uint8_t> content = WithMemoryFor(fmt::format("{} bytes", file.seal().length),
                                                 [&] { return std::vector<uint8_t>(file.seal().length); });
    file.Read(content.data());
    CheckSeal(kind, file.seal(), content);
    return content;
  });
}

}  // namespace plslam
