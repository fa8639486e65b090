#include "tests/unit/structure/configuration_reference.h"

#include "core/bus/options.h"
#include "core/config/config.h"
#include "loop_process/options.h"
#include "mapping_process/options.h"
#include "player/options.h"
#include "viewer_headless/options.h"
#include "vo_process/options.h"

namespace plslam::test {
namespace {

/// Option structs of all processes, by section.
struct AllOptions {
  bus::BusOptions bus;
  PlayerOptions player;
  VoOptions vo;
  MappingOptions mapping;
  LoopOptions loop;
  ViewerOptions viewer;
};

struct Section {
  std::string name;
  std::string meaning;
  std::vector<Field> fields;
};

std::vector<Section> Sections(AllOptions& all) {
  return {{"bus", "How each process joins the bus.", ListFields(all.bus)},
          {"player", "What is played, and how.", ListFields(all.player)},
          {"vo", "Odometry (PL-SLAM §IV).", ListFields(all.vo)},
          {"mapping", "The map (PL-SLAM §V).", ListFields(all.mapping)},
          {"loop", "Places seen before (PL-SLAM §VI).", ListFields(all.loop)},
          {"viewer", "What is written and drawn.", ListFields(all.viewer)}};
}

}  // namespace

std::string ConfigurationReference() {
  AllOptions defaults;
  std::string text = R"(# Configuration

One YAML file serves all processes (`--config FILE`); each reads its own section and `bus`. Single options are set over
the file with `--set vo.features.orb.max_points=800`, as often as needed; the last one wins. `config/plslam.yaml` has all
of them at their defaults, to copy from.

Unknown keys, duplicate keys, wrong types and values out of bounds stop a process before the first frame, with one
sentence that names file, line, key and the nearest known key. What a process really uses stands in its status messages
and in `summary.json`.

This file is generated from the option structs by `scripts/document`; a test compares.
)";
  for (const Section& section : Sections(defaults)) {
    text +=
        "\n## " + section.name + "\n\n" + section.meaning + "\n\n" + FieldsToMarkdown(section.name, section.fields);
  }
  return text;
}

std::string ConfigurationFile() {
  AllOptions defaults;
  std::string yaml =
      "# All options at their defaults, which serve cars, quadrotors, hand-held cameras and RGB-D alike. Copy what "
      "you change: "
      "what a file\n# leaves out keeps its default.\n";
  for (const Section& section : Sections(defaults)) {
    yaml += "\n# " + section.meaning + "\n" + FieldsToYaml(section.name, section.fields, true);
  }
  return yaml;
}

}  // namespace plslam::test
