// SPDX-License-Identifier: BSD-3-Clause
#include "core/places/vocabulary_tree.h"

#include <fmt/format.h>

#include <algorithm>

namespace plslam {
namespace {

/// Levels below the root.
int DepthOf(const std::vector<int32_t>& child_begin) {
  int depth = 0;
  for (int begin = 0, end = 1;; ++depth) {
    const int next_begin = child_begin[begin];
    const int next_end = child_begin[end];
    if (next_begin == next_end) return depth;
    begin = next_begin;
    end = next_end;
  }
}

}  // namespace

std::string LinkNodes(const std::vector<uint8_t>& children, VocabularyTree& tree) {
  const auto nodes = static_cast<int64_t>(children.size());
  tree.child_begin.assign(1, 1);
  tree.word.clear();
  int64_t next = 1;
  int32_t words = 0;
  for (int64_t node = 0; node < nodes; ++node) {
    if (next <= node) return fmt::format("node {} has no parent", node);
    const int count = children[node];
    if (count == 1 || count > VocabularyLimits::kMaxBranching) {
      return fmt::format("node {} has {} children, not 0 or 2 to {}", node, count, VocabularyLimits::kMaxBranching);
    }
    next += count;
    if (next > nodes) return fmt::format("the children of node {} are missing", node);
    tree.child_begin.push_back(static_cast<int32_t>(next));
    tree.word.push_back(count == 0 ? words++ : -1);
  }
  if (nodes == 0 || next != nodes) return fmt::format("it has {} nodes, of which {} are linked", nodes, next);
  const int depth = DepthOf(tree.child_begin);
  if (depth > VocabularyLimits::kMaxDepth) {
    return fmt::format("it has {} levels, more than {}", depth, VocabularyLimits::kMaxDepth);
  }
  return "";
}

}  // namespace plslam
