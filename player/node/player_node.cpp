// SPDX-License-Identifier: BSD-3-Clause
#include "player/node/player_node.h"

#include <memory>

#include "player/dataset_source.h"

namespace plslam::player {
namespace {

stream::SenderOptions SenderOptionsOf(const PlayerOptions& options) {
  return {stream::ParsePace(options.pace), options.skip_bad, options.exit, options.resume_after, options.paused};
}

std::unique_ptr<stream::FrameSource> Open(bus::Process& process, const PlayerOptions& options) {
  auto source = std::make_unique<DatasetSource>(options);
  PlayerOptions shown = options;
  process.SetConfiguration(ToYaml("player", shown));
  return source;
}

}  // namespace

PlayerNode::PlayerNode(bus::Process& process, const PlayerOptions& options)
    : sender_(process, Open(process, options), SenderOptionsOf(options)) {}

}  // namespace plslam::player
