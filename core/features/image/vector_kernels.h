// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Function attribute that compiles a hot INTEGER kernel for several processors; the loader chooses. Not for floating
/// point: results must not depend on the machine. Off under sanitizers, whose runtimes are not ready when the loader
/// resolves clones, and under clang, whose clones differ.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(PLSLAM_SANITIZED)
#define PLSLAM_POPCNT_CLONES __attribute__((target_clones("popcnt", "default")))
#define PLSLAM_AVX2_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define PLSLAM_POPCNT_CLONES
#define PLSLAM_AVX2_CLONES
#endif

namespace plslam {

/// Calls `run(begin, count)` so that a row of independent pixels is processed in whole blocks of vector code: the last
/// block overlaps the previous one, which costs less than single pixels. Only for kernels whose output is not their
/// input.
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
