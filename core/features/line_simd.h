#pragma once

/// Compiles a function for AVX2 as well, chosen at run time. For integer code only, whose result cannot differ. Not
/// with the sanitizers, whose runtime is not up when the choice is made, nor with clang.
#if defined(PLSLAM_SANITIZED) || defined(__clang__) || !defined(__x86_64__)
#define PLSLAM_INTEGER_SIMD
#else
#define PLSLAM_INTEGER_SIMD __attribute__((target_clones("avx2", "default")))
#endif
