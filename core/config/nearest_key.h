// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plslam {

/// Insertions, deletions, replacements and swaps of neighbours that turn one text into the other (optimal string
/// alignment distance).
int EditDistance(std::string_view a, std::string_view b);

/// The key of `known`, or the group of keys of as many parts as `key`, that a person who wrote `key` will have meant.
/// Dotted keys are compared part by part; a part that is left out costs as much as two wrong letters, one too many as
/// five. The first of equals; empty where `known` is.
std::string NearestKey(std::string_view key, const std::vector<std::string>& known);

}  // namespace plslam
