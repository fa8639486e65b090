// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>

#include "core/process/process_arguments.h"
#include "tools/plslam/commands.h"
#include "tools/plslam/node/save_node.h"

namespace plslam {
namespace {

constexpr std::chrono::milliseconds kTick(50);
constexpr std::chrono::seconds kHearLimit(10);
constexpr std::chrono::seconds kSaveLimit(120);

struct SaveOptions {
  bus::ProcessArguments common;
  std::string file;
};

int Save(const SaveOptions& options) {
  bus::BusOptions bus_options;
  options.common.MakeConfig().Read("bus", bus_options);
  bus::Bus bus(bus_options, "plslam");
  SaveNode request(bus);
  const std::string path = std::filesystem::absolute(options.file).string();
  const auto began = std::chrono::steady_clock::now();
  bus.Every(kTick, [&] {
    if (request.heard()) request.Send(path);
    const auto passed = std::chrono::steady_clock::now() - began;
    const bool given_up = passed > (request.heard() ? kSaveLimit : kHearLimit);
    if (given_up || request.result() != SaveNode::Result::kPending) bus.Stop();
  });
  bus.Run();
  if (request.result() == SaveNode::Result::kSaved) {
    fmt::print("the map is in {}\n", path);
    return 0;
  }
  if (request.result() == SaveNode::Result::kFailed) {
    fmt::print(stderr, "plslam: error: {}\n", request.reason());
    return 1;
  }
  fmt::print(stderr, "plslam: error: {}: {}\n", path,
             !request.heard() ? NobodyHeard(bus_options, kHearLimit) : "mapping_process has not answered");
  return 1;
}

}  // namespace

void AddSaveCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<SaveOptions>();
  auto* sub = app->add_subcommand("save", "has the running mapping_process save its map");
  sub->add_option("file", options->file, "map file to write, on the machine of mapping_process")->required();
  options->common.AddTo(sub);
  sub->footer("Example:\n  plslam save out/house.plmap --url udpm://239.255.76.67:7667?ttl=0");
  sub->callback([=] { *command = [options] { return Save(*options); }; });
}

}  // namespace plslam
