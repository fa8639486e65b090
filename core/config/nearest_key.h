// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plslam {

/// Insertions, deletions, replacements and swaps of neighbours that turn one text into the other (optimal string
/// alignment distance).
int EditDistance(std::string_view a, std::string_view b);

/// Returns the key of `known`, or the group of keys with as many parts as `key`, that the user most likely intended by
/// `key`. Dotted keys are compared part by part; a missing part costs as much as two wrong letters, an additional one
/// as five. The first of equal ones; empty if `known` is.
std::string NearestKey(std::string_view key, const std::vector<std::string>& known);

}  // namespace plslam
