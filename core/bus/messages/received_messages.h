// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace plslam::bus {

/// The process whose message arrived last, and the number of its messages so far. Compared with the count in the
/// process's status it reveals whether more messages are on their way.
struct ReceivedMessages {
  int64_t source = 0;
  int64_t n = 0;

  void Add(int64_t from) {
    if (from != source) *this = {from, 0};
    ++n;
  }
};

}  // namespace plslam::bus
