// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process.h"
#include "core/run/process_names.h"
#include "player/command_line.h"
#include "player/node/player_node.h"

int main(int argc, char** argv) {
  plslam::player::PlayerCommandLine command_line;
  plslam::bus::ProcessSpec spec;
  spec.name = plslam::process_name::kPlayer;
  spec.description = "Plays a stereo or RGB-D dataset, or a built-in world, onto the bus.";
  spec.examples =
      "  player /data/kitti/03\n"
      "  player /data/euroc/MH_01 --pace realtime --skip-bad\n"
      "  player 'synthetic:corridor?seed=3' --loop 2 --bounce --exit";
  spec.add_options = [&](void* app) { command_line.AddTo(app); };
  spec.make_node = [&](plslam::bus::Process& process, const plslam::Config& config) {
    return std::make_shared<plslam::player::PlayerNode>(process, command_line.Options(config));
  };
  spec.results = {{"frames.sent", "frames sent"}, {"frames.bad", "unreadable"}, {"frames.late", "late"}};
  return plslam::bus::RunProcess(argc, argv, spec);
}
