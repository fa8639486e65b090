// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace plslam {

/// The values a text option may take.
struct OneOf {
  std::vector<std::string> values;
  OneOf(std::initializer_list<const char*> list) : values(list.begin(), list.end()) {}
  explicit OneOf(std::vector<std::string> list) : values(std::move(list)) {}
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
//     std::string score = "harris";
//   };
//
//   template <class Visitor>
//   void VisitFields(Visitor& visit, OrbOptions& o) {
//     visit("max_points", o.max_points, Bounds{0, 10000}, "largest number of points per image");
//     visit("score", o.score, OneOf{"harris", "fast"}, "what ranks the corners");
//     visit("nested", o.nested, "a struct that has VisitFields itself");
//   }
//
// Field types: bool, int, int64_t, double, std::string, std::vector<double>, and structs with VisitFields. Reading,
// checking, printing, and the generated reference all go through this one list.

}  // namespace plslam
