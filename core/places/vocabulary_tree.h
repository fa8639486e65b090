// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/features/features.h"

namespace plslam {

/// What a vocabulary describes: ORB of points or LBD of lines.
enum class FeatureType : uint8_t { kPoints = 0, kLines = 1 };

/// "points" or "lines".
const char* FeatureTypeName(FeatureType type);

/// Bounds of what a vocabulary may be; a file beyond them is refused.
struct VocabularyLimits {
  static constexpr int kMaxBranching = 64;
  static constexpr int kMaxDepth = 16;
  static constexpr int kMaxNodes = 4'000'000;
};

/// The content of a vocabulary: a tree of descriptors whose leaves are the words.
///
/// Nodes are numbered level by level from the root, 0; the children of a node are neighbours, in the order of their
/// parents. `child_begin[i]` to `child_begin[i + 1]` are the children of node i; none: it is a leaf. Leaves are
/// numbered in the order of the nodes, 0, 1, 2, ...: these numbers are the words.
struct VocabularyTree {
  FeatureType type = FeatureType::kPoints;
  /// Images that it was trained on.
  int64_t images = 0;
  /// Centre of each node; that of the root means nothing.
  std::vector<Descriptor> centers;
  /// One longer than the nodes.
  std::vector<int32_t> child_begin;
  /// Word of each node; -1: no leaf.
  std::vector<int32_t> word;
  /// Inverse document frequency of each word: log(images / images with the word), at least 0.
  std::vector<float> idf;

  int nodes() const { return static_cast<int>(centers.size()); }
  int words() const { return static_cast<int>(idf.size()); }
};

/// Makes `child_begin` and `word` from the number of children of each node. Returns why they are no tree in this
/// numbering (too many, too deep, one child, unreachable nodes), or an empty text.
std::string LinkNodes(const std::vector<uint8_t>& children, VocabularyTree& tree);

}  // namespace plslam
