// SPDX-License-Identifier: BSD-3-Clause
#include "tools/train_vocabulary/vocabulary_trainer.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>

#include "tools/train_vocabulary/clustering.h"

namespace plslam::train_vocabulary {
namespace {

/// A node whose children have not been created yet.
struct OpenNode {
  std::vector<int32_t> members;
  int level = 0;
};

std::vector<Descriptor> Concatenate(const std::vector<std::vector<Descriptor>>& images) {
  std::vector<Descriptor> all;
  for (const auto& image : images) all.insert(all.end(), image.begin(), image.end());
  return all;
}

std::vector<DescriptorCluster> ChildrenOf(const OpenNode& node, const std::vector<Descriptor>& all,
                                          const TrainingOptions& options, std::mt19937_64& random) {
  const auto members = static_cast<int64_t>(node.members.size());
  if (node.level >= options.depth || members < std::max(2, options.min_descriptors)) return {};
  auto clusters = ClusterDescriptors(all, node.members, options.branching, options.max_iterations, random);
  if (clusters.size() < 2) clusters.clear();
  return clusters;
}

/// Centres and numbers of children, level by level.
std::vector<uint8_t> Grow(const std::vector<Descriptor>& all, const TrainingOptions& options,
                          const std::function<void(double)>& progress, VocabularyTree& tree) {
  std::mt19937_64 random(options.seed);
  std::deque<OpenNode> open(1);
  open.front().members.resize(all.size());
  std::iota(open.front().members.begin(), open.front().members.end(), 0);
  tree.centers.assign(1, Descriptor{});
  std::vector<uint8_t> children;
  const double work = static_cast<double>(all.size()) * (options.depth + 1) + 1.0;
  for (double done = 0.0; !open.empty(); open.pop_front()) {
    const OpenNode& node = open.front();
    auto clusters = ChildrenOf(node, all, options, random);
    children.push_back(static_cast<uint8_t>(clusters.size()));
    for (DescriptorCluster& cluster : clusters) {
      tree.centers.push_back(cluster.center);
      open.push_back({std::move(cluster.members), node.level + 1});
    }
    done += static_cast<double>(node.members.size()) * (clusters.empty() ? options.depth + 1 - node.level : 1);
    if (progress) progress(done / work);
  }
  return children;
}

/// Images that have each word.
std::vector<int64_t> ImagesWithWord(const std::vector<std::vector<Descriptor>>& images, const Vocabulary& counting) {
  std::vector<int64_t> count(counting.words(), 0);
  for (const auto& image : images) {
    for (const auto& [word, weight] : counting.Transform(image).words) ++count[word];
  }
  return count;
}

}  // namespace

Vocabulary TrainVocabulary(const std::vector<std::vector<Descriptor>>& images, FeatureType type,
                           const TrainingOptions& options, const std::function<void(double)>& progress) {
  VocabularyTree tree;
  tree.type = type;
  tree.images = static_cast<int64_t>(images.size());
  const std::string objection = LinkNodes(Grow(Concatenate(images), options, progress, tree), tree);
  if (!objection.empty()) throw std::invalid_argument("this vocabulary cannot be stored: " + objection);
  const auto words = static_cast<size_t>(tree.word.back()) + 1;
  tree.idf.assign(words, 1.0F);
  const std::vector<int64_t> with_word = ImagesWithWord(images, Vocabulary(tree));
  for (size_t word = 0; word < words; ++word) {
    const auto count = static_cast<double>(with_word[word]);
    tree.idf[word] = count > 0.0 ? static_cast<float>(std::log(static_cast<double>(images.size()) / count)) : 0.0F;
  }
  return Vocabulary(std::move(tree));
}

}  // namespace plslam::train_vocabulary
