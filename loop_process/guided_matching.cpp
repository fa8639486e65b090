// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/guided_matching.h"

#include <cstddef>
#include <map>

#include "core/features/matching/descriptor_matcher.h"

namespace plslam::loop {
namespace {

// Descriptors of one vocabulary node, and their indices in the whole list.
struct NodeMembers {
  std::vector<Descriptor> descriptors;
  std::vector<int> places;
};

std::map<int32_t, NodeMembers> ByNode(const std::vector<Descriptor>& descriptors, const FeatureNodes& nodes) {
  std::map<int32_t, NodeMembers> by_node;
  for (size_t i = 0; i < descriptors.size() && i < nodes.node.size(); ++i) {
    NodeMembers& members = by_node[nodes.node[i]];
    members.descriptors.push_back(descriptors[i]);
    members.places.push_back(static_cast<int>(i));
  }
  return by_node;
}

}  // namespace

std::vector<int> MatchByNodes(const std::vector<Descriptor>& a, const FeatureNodes& nodes_a,
                              const std::vector<Descriptor>& b, const FeatureNodes& nodes_b,
                              const MatchOptions& options) {
  std::vector<int> matches(a.size(), -1);
  const std::map<int32_t, NodeMembers> of_b = ByNode(b, nodes_b);
  for (const auto& [node, members_a] : ByNode(a, nodes_a)) {
    const auto members_b = of_b.find(node);
    if (members_b == of_b.end()) continue;
    const std::vector<int> found = MatchBruteForce(members_a.descriptors, members_b->second.descriptors, options);
    for (size_t i = 0; i < found.size(); ++i) {
      if (found[i] < 0) continue;
      matches[static_cast<size_t>(members_a.places[i])] = members_b->second.places[static_cast<size_t>(found[i])];
    }
  }
  return matches;
}

}  // namespace plslam::loop
