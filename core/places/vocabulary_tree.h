// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config/choices.h"
#include "core/features/features.h"

namespace plslam {

/// Feature type of a vocabulary: ORB of points or LBD of lines.
enum class FeatureType : uint8_t { kPoints = 0, kLines = 1 };
constexpr auto ChoicesOf(FeatureType) {
  return std::array{Choice{"points", FeatureType::kPoints}, Choice{"lines", FeatureType::kLines}};
}

/// Bounds of a vocabulary; a file beyond them is rejected.
struct VocabularyLimits {
  static constexpr int kMaxBranching = 64;
  static constexpr int kMaxDepth = 16;
  static constexpr int kMaxNodes = 4'000'000;
};

/// The content of a vocabulary: a tree of descriptors whose leaves are the words.
///
/// Nodes are numbered level by level from the root, 0; the children of a node are consecutive, in the order of their
/// parents. `child_begin[i]` up to `child_begin[i + 1]` are the children of node i; a node without children is a leaf.
/// Leaves are numbered in the order of the nodes, 0, 1, 2, ...: these numbers are the words.
struct VocabularyTree {
  FeatureType type = FeatureType::kPoints;
  /// Number of training images.
  int64_t images = 0;
  /// Centre of each node; that of the root is unused.
  std::vector<Descriptor> centers;
  /// Size: number of nodes + 1.
  std::vector<int32_t> child_begin;
  /// Word of each node; -1 if it is not a leaf.
  std::vector<int32_t> word;
  /// Inverse document frequency of each word: log(images / images with the word), at least 0.
  std::vector<float> idf;

  int nodes() const { return static_cast<int>(centers.size()); }
  int words() const { return static_cast<int>(idf.size()); }
};

/// Sets `child_begin` and `word` from the number of children of each node. Returns why they do not form a tree in this
/// numbering (too many, too deep, one child, unreachable nodes), or an empty string.
std::string LinkNodes(const std::vector<uint8_t>& children, VocabularyTree& tree);

}  // namespace plslam
