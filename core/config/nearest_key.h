#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plslam {

/// Insertions, deletions, replacements and swaps of neighbours that turn one text into the other (optimal string
/// alignment distance).
int EditDistance(std::string_view a, std::string_view b);

/// The key of `known` with the smallest edit distance to `key`, the first of equals; empty where `known` is.
std::string NearestKey(std::string_view key, const std::vector<std::string>& known);

}  // namespace plslam
