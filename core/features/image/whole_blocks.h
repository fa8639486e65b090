// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam {

/// Calls `run(begin, count)` so that a row of independent pixels is done in whole blocks of vector code: the last
/// block overlaps the one before, which costs less than a remainder pixel by pixel. Only for kernels whose output is
/// not their input.
template <int kBlock, class Run>
void InWholeBlocks(int count, const Run& run) {
  const int whole = count / kBlock * kBlock;
  if (whole > 0) run(0, whole);
  if (whole == count) return;
  if (whole > 0) {
    run(count - kBlock, kBlock);
  } else {
    run(0, count);
  }
}

}  // namespace plslam
