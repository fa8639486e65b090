// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace plslam::evaluate {
namespace {

constexpr size_t kNamedOptions = 3;

/// Returns the last part of each name, or the complete name if that is ambiguous.
std::string ShortName(const std::string& option, const std::vector<std::string>& options) {
  const std::string last = option.substr(option.rfind('.') + 1);
  const auto has_same_end = [&](const std::string& other) { return other.substr(other.rfind('.') + 1) == last; };
  return std::count_if(options.begin(), options.end(), has_same_end) == 1 ? last : option;
}

std::string LabelOf(const RunRecord& run, const std::vector<std::string>& differing) {
  if (differing.empty()) return "same options";
  std::string label;
  for (size_t i = 0; i < std::min(differing.size(), kNamedOptions); ++i) {
    label +=
        fmt::format("{}{}={}", i == 0 ? "" : ", ", ShortName(differing[i], differing), ValueOf(run, differing[i]));
  }
  if (differing.size() > kNamedOptions) label += fmt::format(", and {} more", differing.size() - kNamedOptions);
  return label;
}

RunGroup* FindGroup(std::vector<RunGroup>& groups, const RunRecord& run) {
  const auto group = std::find_if(groups.begin(), groups.end(), [&](const RunGroup& g) {
    return g.dataset == run.dataset && g.runs.front().options == run.options;
  });
  return group == groups.end() ? nullptr : &*group;
}

/// Inserts the group after the last one of its dataset.
RunGroup& AddGroup(std::vector<RunGroup>& groups, RunGroup group) {
  auto place = groups.end();
  while (place != groups.begin() && std::prev(place)->dataset != group.dataset) --place;
  if (place == groups.begin()) place = groups.end();
  return *groups.insert(place, std::move(group));
}

void Summarise(RunGroup& group) {
  for (size_t i = 0; i < Metrics().size(); ++i) {
    group.metrics.push_back(SpreadOf(group.Values(i), Metrics()[i].larger_is_better));
  }
  for (const RunRecord& run : group.runs) {
    if (!run.completed) ++group.failed;
    if (run.completed && run.untracked) ++group.untracked;
  }
}

/// Appends a number to equal labels, which occur if more options differ than labels name.
void MakeLabelsUnique(std::vector<RunGroup>& groups) {
  std::map<std::pair<std::string, std::string>, int> seen;
  for (RunGroup& group : groups) {
    const int n = ++seen[{group.dataset, group.label}];
    if (n > 1) group.label += fmt::format(" [{}]", n);
  }
}

}  // namespace

Spread SpreadOf(std::vector<double> values, bool larger_is_better) {
  Spread spread;
  spread.n = static_cast<int>(values.size());
  if (values.empty()) return spread;
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  spread.median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  spread.worst = larger_is_better ? values.front() : values.back();
  spread.spread = values.back() - values.front();
  return spread;
}

std::vector<double> RunGroup::Values(size_t metric) const {
  std::vector<double> values;
  for (const RunRecord& run : runs) {
    if (run.completed && run.values[metric]) values.push_back(*run.values[metric]);
  }
  return values;
}

const RunRecord* RunGroup::Typical() const {
  const RunRecord* typical = nullptr;
  double least = 0.0;
  for (const RunRecord& run : runs) {
    if (!run.completed) continue;
    const double distance = run.values[0] ? std::abs(*run.values[0] - metrics[0].median) : 1e300;
    if (typical == nullptr || distance < least) {
      typical = &run;
      least = distance;
    }
  }
  return typical;
}

std::vector<RunGroup> Compare(const std::vector<RunRecord>& runs) {
  std::vector<RunGroup> groups;
  if (runs.empty()) return groups;
  std::vector<const RunRecord*> all;
  all.reserve(runs.size());
  for (const RunRecord& run : runs) all.push_back(&run);
  const std::vector<std::string> differing = DifferingOptions(all);
  for (const RunRecord& run : runs) {
    RunGroup* group = FindGroup(groups, run);
    if (group == nullptr) group = &AddGroup(groups, {run.dataset, LabelOf(run, differing), {}, 0, 0, {}});
    group->runs.push_back(run);
  }
  for (RunGroup& group : groups) Summarise(group);
  MakeLabelsUnique(groups);
  return groups;
}

std::vector<size_t> KnownMetrics(const std::vector<const RunGroup*>& groups) {
  std::vector<size_t> known;
  for (size_t i = 0; i < Metrics().size(); ++i) {
    if (std::any_of(groups.begin(), groups.end(), [&](const RunGroup* g) { return g->metrics[i].n > 0; })) {
      known.push_back(i);
    }
  }
  return known;
}

std::string ValueOf(const RunRecord& run, const std::string& option) {
  const auto value = run.options.find(option);
  return value == run.options.end() ? "-" : value->second;
}

std::vector<std::string> DifferingOptions(const std::vector<const RunRecord*>& runs) {
  std::set<std::string> names;
  for (const RunRecord* run : runs) {
    for (const auto& [name, value] : run->options) names.insert(name);
  }
  std::vector<std::string> differing;
  for (const std::string& name : names) {
    std::set<std::string> values;
    for (const RunRecord* run : runs) {
      if (run->options.contains(name)) values.insert(run->options.at(name));
    }
    if (values.size() > 1) differing.push_back(name);
  }
  std::stable_partition(differing.begin(), differing.end(),
                        [](const std::string& name) { return name == kProcesses; });
  return differing;
}

}  // namespace plslam::evaluate
