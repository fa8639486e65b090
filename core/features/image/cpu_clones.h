// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Function attributes that compile a hot INTEGER kernel several times and let the loader choose by processor. Never
/// for floating point: results must not depend on the machine. Off under sanitizers, whose runtimes are not ready
/// when the loader resolves clones, and under clang, whose clones differ.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(PLSLAM_SANITIZED)
#define PLSLAM_POPCNT_CLONES __attribute__((target_clones("popcnt", "default")))
#define PLSLAM_AVX2_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define PLSLAM_POPCNT_CLONES
#define PLSLAM_AVX2_CLONES
#endif
