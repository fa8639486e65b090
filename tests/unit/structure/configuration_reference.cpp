// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/structure/configuration_reference.h"

#include "core/config/config.h"
#include "tools/plslam/all_options.h"

namespace plslam::test {
std::string ConfigurationReference() {
  launcher::AllOptions defaults;
  std::string text = R"(# Configuration

One YAML file serves all processes (`--config FILE`); each reads its own section and `bus`. Single options are set over
the file with `--set vo.features.orb.max_points=800`; the last one wins. `plslam run` refuses a `--set` that has no
effect, since it starts no such process or another of its options decides. `config/plslam.yaml` has all options at their
defaults.

Unknown or duplicate keys, wrong types and values out of bounds stop a process with one sentence that names file, line
and key. What a process uses stands in its status messages and in `summary.json`; `plslam config --config FILE` prints
it beforehand, with comments: `plslam config --config my.yaml --set vo.features.orb.max_points=800 >effective.yaml`.

This file is generated from the option structs by `scripts/document`.
)";
  for (const launcher::OptionSection& section : launcher::SectionsOf(defaults)) {
    text +=
        "\n## " + section.name + "\n\n" + section.meaning + "\n\n" + FieldsToMarkdown(section.name, section.fields);
  }
  return text;
}

std::string ConfigurationFile() {
  launcher::AllOptions defaults;
  std::string yaml =
      "# All options at their defaults, which serve cars, quadrotors, hand-held cameras and RGB-D alike. Copy what "
      "you change: "
      "what a file\n# leaves out keeps its default.\n";
  for (const launcher::OptionSection& section : launcher::SectionsOf(defaults)) {
    yaml += "\n# " + section.meaning + "\n" + FieldsToYaml(section.name, section.fields, true);
  }
  return yaml;
}

}  // namespace plslam::test
