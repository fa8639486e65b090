// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config/choices.h"
#include "core/config/fields.h"

namespace plslam::test {

/// One field of each kind, for the tests of this folder.
struct InnerOptions {
  double scale = 1.2;
  std::vector<double> sigmas = {1.0, 2.5};
};

enum class Corners { kHarris, kFast };
constexpr auto ChoicesOf(Corners) {
  return std::array{Choice{"harris", Corners::kHarris}, Choice{"fast", Corners::kFast}};
}

struct OuterOptions {
  bool enabled = true;
  int max_points = 1000;
  int64_t seed = 7;
  Corners score = Corners::kHarris;
  std::string folder;
  InnerOptions inner;
};

template <class Visitor>
void VisitFields(Visitor& visit, InnerOptions& o) {
  visit("scale", o.scale, Bounds{1.05, 2.0}, "size ratio");
  visit("sigmas", o.sigmas, Bounds{0, 100}, "deviations");
}

template <class Visitor>
void VisitFields(Visitor& visit, OuterOptions& o) {
  visit("enabled", o.enabled, "in use");
  visit("max_points", o.max_points, Bounds{0, 20000}, "points kept");
  visit("seed", o.seed, Bounds{0, 1e15}, "seed");
  visit("score", o.score, "what ranks the corners");
  visit("folder", o.folder, "where");
  visit("inner", o.inner, "a struct within");
}

}  // namespace plslam::test
