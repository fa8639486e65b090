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

/// For each descriptor the node of the tree at a fixed level that it falls into: descriptors of two images that
/// belong together mostly share it, so that only those need to be compared.
struct FeatureNodes {
  std::vector<int32_t> node;
};

/// A visual vocabulary: a tree that sorts 256-bit descriptors into words, each level choosing the nearest of a few
/// centres (Galvez-Lopez and Tardos, T-RO 2012). Immutable; copies share the tree and are cheap.
class Vocabulary {
 public:
  /// The level of the tree at which `Transform` names nodes: with ten children a node there are a hundred.
  static constexpr int kGuideLevel = 2;

  /// The tree must be as `LinkNodes` makes it, with a centre for each node and a finite weight of at least 0 for each
  /// word.
  explicit Vocabulary(VocabularyTree tree);

  /// Throws std::runtime_error with one sentence where the file is missing, no vocabulary, of another version,
  /// truncated or damaged (a BLAKE2b checksum tells). Memory stays within a small multiple of the file's size.
  static Vocabulary Load(const std::string& path);
  /// The same from the bytes of a file; `name` is for the sentence.
  static Vocabulary FromBytes(std::string_view bytes, const std::string& name);

  /// Replaces the file as a whole. What is loaded from it saves to the same bytes. Throws std::runtime_error.
  void Save(const std::string& path) const;
  std::string ToBytes() const;

  FeatureType type() const { return tree_->type; }
  int words() const { return tree_->words(); }
  const VocabularyTree& tree() const { return *tree_; }
  /// The checksum of its file, 64 hex digits: two vocabularies with the same are the same.
  const std::string& checksum() const { return checksum_; }

  /// The words of an image, weighted by TF-IDF. Words that every training image had weigh nothing and are left out.
  BagOfWords Transform(const std::vector<Descriptor>& descriptors) const;
  /// The same, and the node of each descriptor (see `kGuideLevel`).
  BagOfWords Transform(const std::vector<Descriptor>& descriptors, FeatureNodes& nodes) const;

 private:
  Vocabulary(VocabularyTree tree, std::string checksum);

  std::shared_ptr<const VocabularyTree> tree_;
  std::string checksum_;
};

}  // namespace plslam
