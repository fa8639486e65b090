// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>

namespace plslam::bus::test {

/// Bytes given out by operator new in this program since it was last set to zero.
extern std::atomic<size_t> allocated;

}  // namespace plslam::bus::test
