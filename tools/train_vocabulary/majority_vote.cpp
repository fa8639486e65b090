// SPDX-License-Identifier: BSD-3-Clause
#include "tools/train_vocabulary/majority_vote.h"

namespace plslam {

void MajorityVote::Add(const Descriptor& descriptor) {
  Descriptor carry = descriptor;
  for (Descriptor& plane : planes_) {
    uint64_t left = 0;
    for (size_t w = 0; w < carry.size(); ++w) {
      const uint64_t sum = plane[w] ^ carry[w];
      carry[w] &= plane[w];
      plane[w] = sum;
      left |= carry[w];
    }
    if (left == 0) break;
  }
  ++count_;
  if (++in_planes_ == (1 << kPlanes) - 1) Empty();
}

void MajorityVote::Empty() {
  for (int p = 0; p < kPlanes; ++p) {
    for (int bit = 0; bit < 256; ++bit)
      ones_[bit] += static_cast<int64_t>(planes_[p][bit / 64] >> (bit % 64) & 1U) << p;
  }
  planes_ = {};
  in_planes_ = 0;
}

Descriptor MajorityVote::Majority() {
  Empty();
  Descriptor majority{};
  for (int bit = 0; bit < 256; ++bit) {
    if (2 * ones_[bit] > count_) majority[bit / 64] |= uint64_t{1} << (bit % 64);
  }
  return majority;
}

}  // namespace plslam
