// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace plslam {

/// The values of a text option that are known only at run time.
struct OneOf {
  std::vector<std::string> values;
};

/// Closed interval of the values an option may take.
struct Bounds {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

// An option struct is a plain struct with defaults and one function that lists its fields:
//
//   struct OrbOptions {
//     int max_points = 1000;
//     Corners score = Corners::kHarris;
//   };
//
//   template <class Visitor>
//   void VisitFields(Visitor& visit, OrbOptions& o) {
//     visit("max_points", o.max_points, Bounds{0, 10000}, "largest number of points per image");
//     visit("score", o.score, "what ranks the corners");
//     visit("nested", o.nested, "a struct that has VisitFields itself");
//   }
//
// Field types: bool, int, int64_t, double, std::string, std::vector<double>, enums with names (choices.h), and structs
// with VisitFields. Reading, checking, printing, and the generated reference all go through this one list.

}  // namespace plslam
