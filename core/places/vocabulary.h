// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/places/place_description.h"
#include "core/places/vocabulary_tree.h"

namespace plslam {

/// For each descriptor its node of the tree at a fixed level: corresponding descriptors of two images mostly share it,
/// so that only those need to be compared.
struct FeatureNodes {
  std::vector<int32_t> node;
};

/// A visual vocabulary: a tree that sorts 256-bit descriptors into words, each level choosing the nearest of a few
/// centres (Galvez-Lopez and Tardos, T-RO 2012). Immutable; copies share the tree and are cheap.
class Vocabulary {
 public:
  /// The level of the nodes that `Transform` returns; with ten children per node there are a hundred.
  static constexpr int kGuideLevel = 2;

  /// `tree` must be as `LinkNodes` builds it, with a centre for each node and a finite weight of at least 0 for each
  /// word.
  explicit Vocabulary(VocabularyTree tree);

  /// Throws std::runtime_error with one sentence if the file is missing, not a vocabulary, of another version,
  /// truncated or damaged (checked by BLAKE2b). Memory is at most a small multiple of the file's size.
  static Vocabulary Load(const std::string& path);
  /// The same from the bytes of a file; `name` is used in the error.
  static Vocabulary FromBytes(std::string_view bytes, const std::string& name);

  /// Replaces the file atomically. A loaded vocabulary is saved to the same bytes. Throws std::runtime_error.
  void Save(const std::string& path) const;
  std::string ToBytes() const;

  FeatureType type() const { return tree_->type; }
  int words() const { return tree_->words(); }
  const VocabularyTree& tree() const { return *tree_; }
  /// The checksum of its file, 64 hex digits; equal for equal vocabularies.
  const std::string& checksum() const { return checksum_; }

  /// Returns the words of an image, weighted by TF-IDF. Words of all training images have zero weight and are omitted.
  BagOfWords Transform(const std::vector<Descriptor>& descriptors) const;
  /// The same, with the node of each descriptor (see `kGuideLevel`).
  BagOfWords Transform(const std::vector<Descriptor>& descriptors, FeatureNodes& nodes) const;

 private:
  Vocabulary(VocabularyTree tree, std::string checksum);

  std::shared_ptr<const VocabularyTree> tree_;
  std::string checksum_;
};

}  // namespace plslam
