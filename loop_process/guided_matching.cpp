#include "loop_process/guided_matching.h"

#include <cstddef>
#include <map>

#include "core/features/descriptor_matcher.h"

namespace plslam {
namespace {

// Descriptors of one node, and their places in the whole list.
struct Bucket {
  std::vector<Descriptor> descriptors;
  std::vector<int> places;
};

std::map<int32_t, Bucket> Buckets(const std::vector<Descriptor>& descriptors, const FeatureNodes& nodes) {
  std::map<int32_t, Bucket> buckets;
  for (size_t i = 0; i < descriptors.size() && i < nodes.node.size(); ++i) {
    Bucket& bucket = buckets[nodes.node[i]];
    bucket.descriptors.push_back(descriptors[i]);
    bucket.places.push_back(static_cast<int>(i));
  }
  return buckets;
}

}  // namespace

std::vector<int> MatchByNodes(const std::vector<Descriptor>& a, const FeatureNodes& nodes_a,
                              const std::vector<Descriptor>& b, const FeatureNodes& nodes_b,
                              const MatchOptions& options) {
  std::vector<int> matches(a.size(), -1);
  const std::map<int32_t, Bucket> of_b = Buckets(b, nodes_b);
  for (const auto& [node, bucket_a] : Buckets(a, nodes_a)) {
    const auto bucket_b = of_b.find(node);
    if (bucket_b == of_b.end()) continue;
    const std::vector<int> found = MatchBruteForce(bucket_a.descriptors, bucket_b->second.descriptors, options);
    for (size_t i = 0; i < found.size(); ++i) {
      if (found[i] < 0) continue;
      matches[static_cast<size_t>(bucket_a.places[i])] = bucket_b->second.places[static_cast<size_t>(found[i])];
    }
  }
  return matches;
}

}  // namespace plslam
