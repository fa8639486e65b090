// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

namespace plslam {

/// Accepts whole numbers from `least` on. Those of CLI11 name the largest double as the other bound, in 309 digits.
inline CLI::Validator WholeNumberFrom(int64_t least) {
  const auto check = [least](const std::string& text) {
    int64_t number = 0;
    const bool is_ok = CLI::detail::lexical_cast(text, number) && number >= least;
    return is_ok ? std::string() : fmt::format("'{}' is not a whole number of at least {}", text, least);
  };
  return {check, fmt::format(">={}", least)};
}

/// Accepts numbers above 0.
inline CLI::Validator PositiveNumber() {
  const auto check = [](const std::string& text) {
    double number = 0.0;
    const bool is_ok = CLI::detail::lexical_cast(text, number) && number > 0.0;
    return is_ok ? std::string() : fmt::format("'{}' is not a number above 0", text);
  };
  return {check, ">0"};
}

}  // namespace plslam
