// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "core/process/process_arguments.h"
#include "tools/plslam/all_options.h"
#include "tools/plslam/commands.h"

namespace plslam {
namespace {

/// What the processes would take of the file and the overrides, checked as they check it.
int PrintConfiguration(const bus::ProcessArguments& arguments) {
  const Config config = arguments.MakeConfig();
  AllOptions all;
  std::string text;
  for (const OptionSection& section : SectionsOf(all)) {
    config.ReadFields(section.name, section.fields);
    text += fmt::format("{}# {}\n{}", text.empty() ? "" : "\n", section.meaning,
                        FieldsToYaml(section.name, section.fields, true));
  }
  fmt::print("{}", text);
  return 0;
}

}  // namespace

void AddConfigCommand(CLI::App* app, Command* command) {
  auto arguments = std::make_shared<bus::ProcessArguments>();
  auto* sub =
      app->add_subcommand("config", "prints the configuration that processes would use, with what each option means");
  sub->add_option("--config", arguments->config_file,
                  "YAML file with options of all processes (docs/configuration.md)")
      ->type_name("FILE");
  sub->add_option("--set", arguments->overrides,
                  "one option, over the file: vo.features.orb.max_points=800 (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub->footer(
      "Examples:\n"
      "  plslam config > mine.yaml\n"
      "  plslam config --config mine.yaml --set vo.features.orb.max_points=800\n"
      "What it prints is a configuration file itself.");
  sub->callback([=] { *command = [arguments] { return PrintConfiguration(*arguments); }; });
}

}  // namespace plslam
