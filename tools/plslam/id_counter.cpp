// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/id_counter.h"

namespace plslam {

void IdCounter::Add(int64_t session, int64_t id) {
  if (id < 0) return;
  const std::pair block(session, id / kBlock);
  if (blocks_.size() >= kMaxBlocks && !blocks_.contains(block)) return;
  auto bit = blocks_[block][static_cast<size_t>(id % kBlock)];
  if (bit) return;
  bit = true;
  ++count_;
}

int64_t IdCounter::bytes() const {
  return static_cast<int64_t>(blocks_.size() * sizeof(decltype(blocks_)::value_type));
}

}  // namespace plslam
