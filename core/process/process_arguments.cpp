// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process_arguments.h"

#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <stdexcept>

#include "core/config/config.h"

namespace plslam::bus {

void ProcessArguments::AddTo(CLI::App* app) {
  app->add_option("--config", config_file, "YAML file with the options")->type_name("FILE");
  app->add_option("--set", overrides, "one option, overrides the file: vo.features.orb.max_points=800 (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app->add_option("--url", url, "LCM URL, for example udpm://239.255.76.67:7667?ttl=0 [LCM_DEFAULT_URL, or this]");
  app->add_option("--prefix", prefix, "prefix of each channel name");
  app->add_option("--map-prefix", map_prefix, "prefix of the map that is shared with other robots");
  app->add_option("--parent", parent, "exit when the process with this id, which started this one, exits")
      ->type_name("PID")
      ->group("");  // for plslam
  app->add_flag("--own-bus", own_bus, "no other run can be on the bus: do not look for processes of the same name")
      ->group("");
}

Config ProcessArguments::MakeConfig() const {
  Config config = config_file.empty() ? Config() : Config::FromFile(config_file);
  for (const std::string& assignment : overrides) config.Override(assignment);
  if (url) config.Override("bus.url=" + *url);
  if (prefix) config.Override("bus.prefix=" + *prefix);
  if (map_prefix) config.Override("bus.map_prefix=" + *map_prefix);
  config.RequireSections(kConfigSections);
  return config;
}

void ProcessArguments::EndWithParent() const {
  if (parent == 0) return;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  // It may have ended before the kernel knew of our wish.
  if (getppid() != parent) throw std::runtime_error("the process that started this one has exited");
}

void SetUpLogging(const std::string& process) {
  // Colours are for terminals, unless the user disables them (no-color.org).
  const char* const no_colour = std::getenv("NO_COLOR");
  const bool never = no_colour != nullptr && *no_colour != '\0';
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>(never ? spdlog::color_mode::never
                                                                          : spdlog::color_mode::automatic);
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(process, std::move(sink)));
  spdlog::set_pattern("%H:%M:%S.%e %n %^%l%$: %v");
  spdlog::flush_on(spdlog::level::trace);
}

std::string OneLine(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace plslam::bus
