// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace plslam::test {

/// Seeded damage to the bytes of text and image files.
class DatasetMutator {
 public:
  explicit DatasetMutator(uint64_t seed) : random_(seed) {}

  /// 0 .. n - 1, the same on every machine.
  int Below(int n);

  /// One to three of: flipped, inserted and removed bytes, truncation, numbers replaced by extreme ones, lines
  /// removed, doubled and exchanged, the content of `other`, and a PNG header of another size with its checksum
  /// right.
  std::string Mutate(std::string bytes, std::string_view other);

 private:
  void MutateOnce(std::string& bytes, std::string_view other);
  void FlipBytes(std::string& bytes);
  void Splice(std::string& bytes);
  void ReplaceNumber(std::string& bytes);
  void ChangeLines(std::string& bytes);
  void ResizePng(std::string& bytes);

  std::mt19937_64 random_;
};

}  // namespace plslam::test
