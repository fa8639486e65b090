// SPDX-License-Identifier: BSD-3-Clause
#include "player/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "core/datasets/open_dataset.h"
#include "core/stream/pacing.h"

namespace plslam::player {

void PlayerCommandLine::AddTo(void* app) {
  auto& cli = *static_cast<CLI::App*>(app);
  cli.add_option("DATASET", dataset_, DatasetHelp());
  cli.add_option("--kind", kind_, DatasetKindHelp() + "; default: recognised from its files");
  cli.add_option("--topics", topics_, "LEFT RIGHT: image topics of a ROS recording; default: recognised by name")
      ->type_name("TOPIC")
      ->expected(2);
  cli.add_option("--pace", pace_, "lockstep (default), realtime, or realtimexN (realtimex2: twice as fast)")
      ->type_name("TEXT:{lockstep,realtime}");
  cli.add_option("--start", start_, "first frame")->default_str("0");
  cli.add_option("--stop", stop_, "frame before which to stop; -1: the end")->default_str("-1");
  cli.add_option("--stride", stride_, "play every n-th frame")->default_str("1");
  cli.add_option("--loop", loop_, "number of times to play the dataset, with continuous times and frame ids")
      ->default_str("1");
  cli.add_flag("--bounce", bounce_, "play forth and back each time, so that the path closes");
  cli.add_flag("--skip-bad", skip_bad_, "skip unreadable frames, and count them");
  cli.add_flag("--resume", resume_, "continue after the frames that have a pose on the bus: after a crash");
  cli.add_flag("--exit", exit_, "exit when all frames are sent and acknowledged");
}

PlayerOptions PlayerCommandLine::Options(const Config& config) const {
  PlayerOptions options;
  // Overrides of the configuration, so that its checks of types and bounds hold for the command line too.
  Config with_overrides = config;
  const auto override_with = [&](const char* key, const auto& value) {
    if (value) with_overrides.Override(fmt::format("player.{}={}", key, *value));
  };
  override_with("start", start_);
  override_with("stop", stop_);
  override_with("stride", stride_);
  override_with("loop", loop_);
  with_overrides.Read("player", options);
  if (dataset_) options.dataset = *dataset_;
  if (kind_) options.kind = *kind_;
  options.dataset = WithTopics(options.dataset, options.kind, topics_);
  if (pace_) options.pace = *pace_;
  options.bounce |= bounce_;
  options.skip_bad |= skip_bad_;
  options.exit |= exit_;
  if (resume_) options.resume_after = stream::kResumeFromBus;
  return options;
}

}  // namespace plslam::player
