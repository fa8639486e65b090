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
#include "tools/plslam/commands.h"

namespace plslam::launcher {
namespace {

/// Becomes plslam_bridge, which is a program of its own because it alone has the libraries of WebSockets.
int Bridge(std::vector<std::string> arguments) {
  const std::string program = (ProgramFolder() / "plslam_bridge").string();
  arguments.insert(arguments.begin(), program);
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  execv(program.c_str(), words.data());
  PrintError(fmt::format(
      "plslam: error: the program {} is missing: install the package plslam-bridge (or libwebsockets-dev, "
      "and build again)",
      program));
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
  sub->callback([=] { *command = [arguments = sub->remaining()] { return Bridge(arguments); }; });
}

}  // namespace plslam::launcher
