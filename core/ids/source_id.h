// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/ids/ids.h"

namespace plslam {

struct SourceKind {
  static constexpr int64_t kNone = 0;
};
/// A process that publishes or reads, from its start to its end (`header_t.source`). A random number; 0: none, or all.
using SourceId = Id<SourceKind>;

}  // namespace plslam
