// SPDX-License-Identifier: BSD-3-Clause
#include "core/places/vocabulary.h"
#include "core/errors/error_text.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "core/features/image/vector_kernels.h"
#include "core/files/atomic_file.h"

namespace plslam {
namespace {

struct Fall {
  int32_t leaf = 0;
  int32_t guide = 0;
};

/// Finds the leaf of each descriptor, and the node that it passes at the guide level (its leaf, if that is higher up).
/// The first of equally near centres is taken.
PLSLAM_POPCNT_CLONES
void FallThrough(const Descriptor* centers, const int32_t* child_begin, const Descriptor* descriptors, size_t count,
                 int guide_level, Fall* falls) {
  for (size_t i = 0; i < count; ++i) {
    const Descriptor& d = descriptors[i];
    int32_t node = 0;
    int32_t guide = 0;
    for (int level = 1; child_begin[node] < child_begin[node + 1]; ++level) {
      const int32_t end = child_begin[node + 1];
      int nearest = 257;
      for (int32_t child = child_begin[node]; child < end; ++child) {
        const Descriptor& c = centers[child];
        const int distance = std::popcount(c[0] ^ d[0]) + std::popcount(c[1] ^ d[1]) + std::popcount(c[2] ^ d[2]) +
                             std::popcount(c[3] ^ d[3]);
        node = distance < nearest ? child : node;
        nearest = std::min(nearest, distance);
      }
      if (level <= guide_level) guide = node;
    }
    falls[i] = {node, guide};
  }
}

std::vector<Fall> FallThrough(const VocabularyTree& tree, const std::vector<Descriptor>& descriptors) {
  std::vector<Fall> falls(descriptors.size());
  FallThrough(tree.centers.data(), tree.child_begin.data(), descriptors.data(), descriptors.size(),
              Vocabulary::kGuideLevel, falls.data());
  return falls;
}

BagOfWords Count(const VocabularyTree& tree, const std::vector<Fall>& falls) {
  std::vector<int32_t> words;
  words.reserve(falls.size());
  for (const Fall& fall : falls) {
    const int32_t word = tree.word[fall.leaf];
    if (tree.idf[word] > 0.0F) words.push_back(word);
  }
  std::sort(words.begin(), words.end());
  BagOfWords bag;
  bag.words.reserve(words.size());
  double sum = 0.0;
  for (size_t i = 0; i < words.size();) {
    const size_t first = i;
    while (i < words.size() && words[i] == words[first]) ++i;
    const float weight = static_cast<float>(i - first) * tree.idf[words[first]];
    bag.words.emplace_back(words[first], weight);
    sum += weight;
  }
  for (auto& [word, weight] : bag.words) weight = static_cast<float>(weight / sum);
  return bag;
}

}  // namespace

BagOfWords Vocabulary::Transform(const std::vector<Descriptor>& descriptors) const {
  return Count(*tree_, FallThrough(*tree_, descriptors));
}

BagOfWords Vocabulary::Transform(const std::vector<Descriptor>& descriptors, FeatureNodes& nodes) const {
  const std::vector<Fall> falls = FallThrough(*tree_, descriptors);
  nodes.node.clear();
  for (const Fall& fall : falls) nodes.node.push_back(fall.guide);
  return Count(*tree_, falls);
}

// File format: header, number of children of each node (1 byte each), centre of each node except the root, IDF of each
// word, BLAKE2b-256 of all of this. Little-endian, without gaps.

namespace {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

constexpr std::array<char, 8> kMagic{'P', 'L', 'S', 'V', 'O', 'C', 'A', 'B'};
constexpr uint32_t kVersion = 1;
constexpr size_t kChecksumBytes = 32;
constexpr float kMaxIdf = 100.0F;

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kVersion;
  uint32_t kind = 0;
  int64_t images = 0;
  uint32_t nodes = 0;
  uint32_t words = 0;
};
static_assert(sizeof(Header) == 32);

size_t BytesOf(const Header& header) {
  return sizeof(Header) + size_t{header.nodes} + sizeof(Descriptor) * (size_t{header.nodes} - 1) +
         sizeof(float) * size_t{header.words} + kChecksumBytes;
}

std::string Checksum(std::string_view bytes) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
  std::string sum(kChecksumBytes, '\0');
  crypto_generichash(reinterpret_cast<unsigned char*>(sum.data()), sum.size(),
                     reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), nullptr, 0);
  return sum;
}

std::string Hex(std::string_view bytes) {
  std::string text;
  for (const char byte : bytes) text += fmt::format("{:02x}", static_cast<uint8_t>(byte));
  return text;
}

template <class T>
void Put(std::string& bytes, const T* values, size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), sizeof(T) * count);
}

template <class T>
void Take(std::string_view& bytes, T* values, size_t count) {
  std::memcpy(values, bytes.data(), sizeof(T) * count);
  bytes.remove_prefix(sizeof(T) * count);
}

[[noreturn]] void Refuse(const std::string& name, const std::string& reason) {
  throw std::runtime_error(fmt::format("vocabulary {} {}", name, reason));
}

/// Returns the header of a file with valid size and checksum.
Header CheckedHeader(std::string_view bytes, const std::string& name) {
  Header header;
  if (bytes.size() < kMagic.size() || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    Refuse(name, "is not a vocabulary of this program");
  }
  if (bytes.size() < sizeof(Header) + kChecksumBytes) Refuse(name, "is truncated: even its header is incomplete");
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (header.version != kVersion) {
    Refuse(name, fmt::format("has format version {}, and this program reads version {}", header.version, kVersion));
  }
  if (header.nodes < 1 || header.nodes > VocabularyLimits::kMaxNodes || header.words > header.nodes) {
    Refuse(name, fmt::format("is damaged: {} nodes and {} words (1 to {})", header.nodes, header.words,
                             VocabularyLimits::kMaxNodes));
  }
  if (bytes.size() != BytesOf(header)) {
    Refuse(name, fmt::format("has {} bytes, but its header states {}", bytes.size(), BytesOf(header)));
  }
  const std::string_view content = bytes.substr(0, bytes.size() - kChecksumBytes);
  if (Checksum(content) != bytes.substr(content.size())) Refuse(name, "is damaged: its checksum is wrong");
  if (header.kind > 1 || header.images < 0) Refuse(name, "is damaged: its type or number of images is impossible");
  return header;
}

std::string ReadWhole(const std::string& path) {
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) Refuse(path, why);
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) Refuse(path, "cannot be read");
  const auto size = static_cast<int64_t>(in.tellg());
  const Header largest{.nodes = VocabularyLimits::kMaxNodes, .words = VocabularyLimits::kMaxNodes};
  // A directory can be opened, and reports a huge size.
  if (size < 0 || size > static_cast<int64_t>(BytesOf(largest))) {
    Refuse(path, fmt::format("has {} bytes, more than any vocabulary", size));
  }
  std::string bytes(static_cast<size_t>(size), '\0');
  in.seekg(0);
  if (!in.read(bytes.data(), size)) Refuse(path, "cannot be read to its end");
  return bytes;
}

}  // namespace

Vocabulary::Vocabulary(VocabularyTree tree, std::string checksum)
    : tree_(std::make_shared<const VocabularyTree>(std::move(tree))), checksum_(std::move(checksum)) {}

Vocabulary::Vocabulary(VocabularyTree tree) : Vocabulary(std::move(tree), "") {
  const std::string bytes = ToBytes();
  checksum_ = Hex(std::string_view(bytes).substr(bytes.size() - kChecksumBytes));
}

Vocabulary Vocabulary::FromBytes(std::string_view bytes, const std::string& name) {
  const Header header = CheckedHeader(bytes, name);
  VocabularyTree tree;
  tree.type = static_cast<FeatureType>(header.kind);
  tree.images = header.images;
  std::vector<uint8_t> children(header.nodes);
  tree.centers.resize(header.nodes);
  tree.idf.resize(header.words);
  std::string_view rest = bytes.substr(sizeof(Header));
  Take(rest, children.data(), children.size());
  Take(rest, tree.centers.data() + 1, tree.centers.size() - 1);
  Take(rest, tree.idf.data(), tree.idf.size());
  const std::string objection = LinkNodes(children, tree);
  if (!objection.empty()) Refuse(name, "is damaged: " + objection);
  if (std::count(children.begin(), children.end(), 0) != static_cast<int64_t>(header.words)) {
    Refuse(name, fmt::format("is damaged: it does not have the {} words of its header", header.words));
  }
  for (const float idf : tree.idf) {
    if (!(idf >= 0.0F && idf <= kMaxIdf)) Refuse(name, fmt::format("is damaged: a word has the weight {}", idf));
  }
  return {std::move(tree), Hex(rest)};
}

Vocabulary Vocabulary::Load(const std::string& path) { return FromBytes(ReadWhole(path), path); }

std::string Vocabulary::ToBytes() const {
  const VocabularyTree& t = *tree_;
  Header header;
  header.kind = static_cast<uint32_t>(t.type);
  header.images = t.images;
  header.nodes = static_cast<uint32_t>(t.nodes());
  header.words = static_cast<uint32_t>(t.words());
  std::string bytes;
  bytes.reserve(BytesOf(header));
  Put(bytes, &header, 1);
  for (int i = 0; i < t.nodes(); ++i) bytes += static_cast<char>(t.child_begin[i + 1] - t.child_begin[i]);
  Put(bytes, t.centers.data() + 1, t.centers.size() - 1);
  Put(bytes, t.idf.data(), t.idf.size());
  return bytes + Checksum(bytes);
}

void Vocabulary::Save(const std::string& path) const { WriteFileAtomically(path, ToBytes()); }

}  // namespace plslam
