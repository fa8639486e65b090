// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/features/features.h"
#include "core/places/vocabulary.h"

namespace plslam::train_vocabulary {

/// Shape of a vocabulary.
struct TrainingOptions {
  /// Children of a node, and levels below the root: at most branching^depth words.
  int branching = 10;
  int depth = 5;
  /// A node with fewer descriptors than this is a word, whatever its level.
  int min_descriptors = 20;
  int max_iterations = 12;
  uint64_t seed = 1;
};

/// Trains a vocabulary by hierarchical k-majority on the descriptors of each image. Equal input gives equal
/// vocabularies. `progress` receives the share of the work done, 0 to 1; it may be empty. Without any descriptor: one
/// word of weight 0. Throws std::invalid_argument if the options exceed VocabularyLimits.
Vocabulary TrainVocabulary(const std::vector<std::vector<Descriptor>>& images, FeatureType type,
                           const TrainingOptions& options, const std::function<void(double)>& progress = {});

}  // namespace plslam::train_vocabulary
