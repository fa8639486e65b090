// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/errors/standard_streams.h"
#include "core/io/files/shared_file.h"
#include "core/process/argument_vector.h"
#include "tools/plslam/commands.h"
#include "tools/plslam/run_options.h"

namespace plslam::launcher {
namespace {

/// Becomes a program of its own, which alone has certain libraries, and is in a package of its own.
int Become(const char* name, const char* packages, std::vector<std::string> arguments) {
  const std::string program = (ProgramFolder() / name).string();
  arguments.insert(arguments.begin(), program);
  execv(program.c_str(), ArgumentVector(arguments).data());
  PrintError(fmt::format("plslam: error: the program {} is missing: 'scripts/build release' builds it, with {}",
                         program, packages));
  return 1;
}

}  // namespace

void AddBridgeCommand(CLI::App* app, Command* command) {
  auto* sub = app->add_subcommand(
      "bridge", "serves a running system live to Foxglove and Lichtblick; options as of plslam_bridge --help");
  sub->prefix_command();
  sub->footer(
      "Examples:\n"
      "  plslam bridge --url udpm://239.255.76.67:7667?ttl=0\n"
      "  plslam bridge --url udpm://239.255.76.67:7667?ttl=0 --address 0.0.0.0");
  sub->callback([=] {
    *command = [arguments = sub->remaining()] {
      return Become("plslam_bridge", "plslam-bridge (or libwebsockets-dev)", arguments);
    };
  });
}

void AddTopicsCommand(CLI::App* app, Command* command) {
  auto source = std::make_shared<std::string>();
  auto* sub = app->add_subcommand("topics", "lists the topics of a robot that speaks ROS 2, and its stereo cameras");
  sub->add_option("source", *source, "ros2:, the domain of ROS_DOMAIN_ID")
      ->required()
      ->type_name("ros2:")
      ->check([](const std::string& name) {
        return name == kRos2Prefix ? std::string()
                                   : fmt::format(
                                         "{} is not {}, the only source whose topics are listed; of a "
                                         "recording, `plslam run` finds or names them",
                                         name, kRos2Prefix);
      });
  sub->footer(
      "Examples:\n"
      "  plslam topics ros2:\n"
      "  ROS_DOMAIN_ID=7 plslam topics ros2:");
  sub->callback([=] {
    *command = [source] {
      return Become("plslam_ros2", "plslam-ros2 (or cyclonedds-dev, cyclonedds-tools and libfastrtps-dev)",
                    {"--topics"});
    };
  });
}

}  // namespace plslam::launcher
