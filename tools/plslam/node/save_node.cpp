// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/save_node.h"

#include <fmt/format.h>

#include <utility>

#include "core/bus/transport/transport.h"
#include "core/process/process_status.h"
#include "core/run/process_names.h"
#include "plslam/command_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::launcher {

std::string NobodyHeard(const bus::BusOptions& options, std::chrono::seconds waited) {
  return fmt::format(
      "no mapping_process is heard on {} with prefix '{}' for {} s; give the --url and --prefix of the one that runs "
      "(plslam run takes a bus of its own where it has no --url), or start one",
      bus::EffectiveUrl(options.url), options.prefix, waited.count());
}

SaveNode::SaveNode(bus::Bus& bus) : bus_(bus) {
  bus_.Subscribe<status_t>(bus::kStatus, [this](const status_t& message) { OnStatus(message); });
}

void SaveNode::OnStatus(const status_t& message) {
  if (message.process != "mapping") return;
  const double saves = bus::CounterOf(message, "map.saves");
  const double failed = bus::CounterOf(message, "map.failed_saves");
  // Before the order, and after a restart of the process (which has forgotten it): what there is to begin with.
  if (!sent_ || message.pid != pid_) {
    pid_ = message.pid;
    saves_ = saves;
    failed_ = failed;
    heard_ = true;
    sent_ = false;
    return;
  }
  if (saves > saves_) result_ = Result::kSaved;
  if (failed <= failed_) return;
  result_ = Result::kFailed;
  reason_ = message.reason;
}

void SaveNode::Send(const std::filesystem::path& path) {
  if (std::exchange(sent_, true)) return;
  command_t command{};
  command.target = process_name::kMapping;
  command.verb = command_verb::kSave;
  command.argument = path.string();
  bus_.Publish(bus::kCommand, command);
}

}  // namespace plslam::launcher
