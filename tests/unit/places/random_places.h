// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "core/features/features.h"
#include "tools/train_vocabulary/vocabulary_trainer.h"

namespace plslam::test {

inline Descriptor RandomDescriptor(std::mt19937_64& random) { return {random(), random(), random(), random()}; }

inline Descriptor Flip(Descriptor descriptor, int bits, std::mt19937_64& random) {
  for (int i = 0; i < bits; ++i) descriptor[random() % 4] ^= uint64_t{1} << (random() % 64);
  return descriptor;
}

inline std::vector<Descriptor> RandomDescriptors(int count, std::mt19937_64& random) {
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) descriptor = RandomDescriptor(random);
  return descriptors;
}

/// Images of descriptors around centres that they share, as the images of a world do.
inline std::vector<std::vector<Descriptor>> RandomImages(int images, int descriptors, std::mt19937_64& random) {
  const std::vector<Descriptor> centers = RandomDescriptors(200, random);
  std::vector<std::vector<Descriptor>> all(images);
  for (auto& image : all) {
    for (int i = 0; i < descriptors; ++i) image.push_back(Flip(centers[random() % centers.size()], 12, random));
  }
  return all;
}

inline Vocabulary SmallVocabulary(FeatureType type) {
  std::mt19937_64 random(5);
  train_vocabulary::TrainingOptions options;
  options.branching = 6;
  options.depth = 3;
  options.min_descriptors = 4;
  return train_vocabulary::TrainVocabulary(RandomImages(40, 60, random), type, options);
}

/// Points and lines anywhere in an image, with descriptors like those of `SmallVocabulary`.
inline ImageFeatures RandomFeatures(int points, int lines, std::mt19937_64& random) {
  const auto pixel = [&] {
    return Eigen::Vector2d{static_cast<double>(random() % 640), static_cast<double>(random() % 480)};
  };
  ImageFeatures features;
  features.points.resize(points);
  features.lines.resize(lines);
  for (PointFeature& point : features.points) point = {.px = pixel(), .descriptor = RandomDescriptor(random)};
  for (LineFeature& line : features.lines) {
    line.segment = {pixel(), pixel()};
    line.descriptor = RandomDescriptor(random);
  }
  return features;
}

/// Another image of the same: each descriptor with some bits changed.
inline ImageFeatures SeenAgain(ImageFeatures features, int bits, std::mt19937_64& random) {
  for (PointFeature& point : features.points) point.descriptor = Flip(point.descriptor, bits, random);
  for (LineFeature& line : features.lines) line.descriptor = Flip(line.descriptor, bits, random);
  return features;
}

}  // namespace plslam::test
