// SPDX-License-Identifier: BSD-3-Clause
#include "player/node/player_node.h"

#include <memory>

#include "core/run/run_counters.h"
#include "player/dataset_source.h"

namespace plslam::player {
namespace {

stream::SenderOptions SenderOptionsOf(const PlayerOptions& options) {
  return {stream::ParsePace(options.pace), options.skip_bad, options.exit, options.resume_after, options.paused};
}

std::unique_ptr<stream::FrameSource> Open(bus::Process& process, const PlayerOptions& options) {
  auto source = std::make_unique<DatasetSource>(options);
  if (source->scan_s() > 0.0) process.SetCounter(kRecordingScan, source->scan_s());
  for (const std::string& warning : source->warnings()) process.Warn("dataset", warning);
  PlayerOptions shown = options;
  process.SetConfiguration(ToYaml("player", shown));
  return source;
}

}  // namespace

PlayerNode::PlayerNode(bus::Process& process, const PlayerOptions& options)
    : sender_(process, Open(process, options), SenderOptionsOf(options)) {}

}  // namespace plslam::player
