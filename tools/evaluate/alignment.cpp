// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/alignment.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <utility>
#include <vector>

namespace plslam {
namespace {

constexpr std::array<std::pair<std::string_view, Alignment>, 4> kNames{
    {{"none", Alignment::kNone}, {"first", Alignment::kFirst}, {"se3", Alignment::kSe3}, {"sim3", Alignment::kSim3}}};

}  // namespace

Similarity Align(const PosePairs& pairs, Alignment alignment) {
  if (pairs.empty() || alignment == Alignment::kNone) return {};
  if (alignment == Alignment::kFirst) return {1.0, pairs[0].truth * pairs[0].estimate.Inverse()};
  std::vector<SE3> truth, estimate;
  for (const PosePair& pair : pairs) {
    truth.push_back(pair.truth);
    estimate.push_back(pair.estimate);
  }
  return AlignPaths(truth, estimate, alignment == Alignment::kSim3);
}

std::string AlignmentName(Alignment alignment) {
  for (const auto& [name, value] : kNames) {
    if (value == alignment) return std::string(name);
  }
  throw std::logic_error("alignment without a name");
}

Alignment AlignmentFromName(std::string_view name) {
  for (const auto& [known, value] : kNames) {
    if (known == name) return value;
  }
  throw std::runtime_error(fmt::format("no alignment '{}' (none, first, se3, sim3)", name));
}

}  // namespace plslam
