// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

/// Arithmetic of the synthetic worlds. Everything here is + - * / sqrt, floor and integers in a fixed order, which
/// IEEE 754 defines to the last bit; the sine of a C library differs between processors and versions.
namespace plslam::synthetic {

inline constexpr double kPi = 3.14159265358979323846;

/// Sine by its Taylor polynomial of degree 21 after reduction to [-pi/2, pi/2]; error below 1e-15 near the origin,
/// and |x| * 1e-16 further out.
inline double Sin(double x) {
  double r = x - std::floor(x / (2.0 * kPi) + 0.5) * (2.0 * kPi);
  if (r > 0.5 * kPi) {
    r = kPi - r;
  } else if (r < -0.5 * kPi) {
    r = -kPi - r;
  }
  const double r2 = r * r;
  double sum = 1.0;
  for (int n = 20; n >= 2; n -= 2) {
    sum = 1.0 - r2 / (n * (n + 1.0)) * sum;
  }
  return r * sum;
}

inline double Cos(double x) { return Sin(x + 0.5 * kPi); }

/// Tangent; x away from odd multiples of pi/2.
inline double Tan(double x) { return Sin(x) / Cos(x); }

/// A well mixed function of its argument (the finaliser of SplitMix64).
inline uint64_t Mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

inline uint64_t Hash(uint64_t a, uint64_t b, uint64_t c = 0) {
  return Mix(Mix(Mix(a + 0x9e3779b97f4a7c15ULL) ^ b) + 0x9e3779b97f4a7c15ULL * (c + 1));
}

/// 3 x^2 - 2 x^3 between 0 and 1, constant outside.
inline double Smoothstep(double x) {
  if (x <= 0.0) {
    return 0.0;
  }
  return x >= 1.0 ? 1.0 : x * x * (3.0 - 2.0 * x);
}

/// SplitMix64: seeded random numbers, equal everywhere, as long as no list of arguments draws twice: GCC evaluates
/// arguments from right to left on amd64 and from left to right on arm64.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(Mix(seed + 0x9e3779b97f4a7c15ULL)) {}

  uint64_t Bits() {
    state_ += 0x9e3779b97f4a7c15ULL;
    return Mix(state_);
  }
  /// In [0, 1).
  double Uniform() { return static_cast<double>(Bits() >> 11) * 0x1p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// In [0, n).
  int Int(int n) { return static_cast<int>((Bits() >> 33) % static_cast<uint64_t>(n)); }
  bool Chance(double probability) { return Uniform() < probability; }

 private:
  uint64_t state_;
};

}  // namespace plslam::synthetic
