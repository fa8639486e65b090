// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "adapter/options.h"
#include "camera/options.h"
#include "core/bus/options.h"
#include "core/config/config.h"
#include "dense_process/options.h"
#include "loop_process/options.h"
#include "mapping_process/options.h"
#include "player/options.h"
#include "ros2/options.h"
#include "tools/bridge/options.h"
#include "viewer_headless/options.h"
#include "vo_process/options.h"

namespace plslam::launcher {

/// Option structs of all processes, one for each section of a configuration.
struct AllOptions {
  bus::BusOptions bus;
  player::PlayerOptions player;
  adapter::AdapterOptions adapter;
  ros2::Ros2Options ros2;
  camera::CameraOptions camera;
  vo::VoOptions vo;
  mapping::MappingOptions mapping;
  loop::LoopOptions loop;
  viewer::ViewerOptions viewer;
  dense::DenseOptions dense;
  bridge::BridgeOptions bridge;
};

struct OptionSection {
  std::string name;
  std::string meaning;
  /// They refer to the options that they were made of.
  std::vector<Field> fields;
};

inline std::vector<OptionSection> SectionsOf(AllOptions& all) {
  return {{kBusSection, "Connection of each process to the bus.", ListFields(all.bus)},
          {"player", "Dataset and playback.", ListFields(all.player)},
          {"adapter", "Connection to a robot that uses LCM.", ListFields(all.adapter)},
          {"ros2", "Connection to a robot that uses ROS 2.", ListFields(all.ros2)},
          {"camera", "Live cameras.", ListFields(all.camera)},
          {"vo", "Odometry (PL-SLAM §IV).", ListFields(all.vo)},
          {"mapping", "The map (PL-SLAM §V).", ListFields(all.mapping)},
          {"loop", "Loop closing and relocalisation (PL-SLAM §VI).", ListFields(all.loop)},
          {"viewer", "Files and pictures that are written.", ListFields(all.viewer)},
          {"dense", "Surfaces and the grid for planning (dense_process).", ListFields(all.dense)},
          {"bridge", "The WebSocket of Foxglove (plslam bridge).", ListFields(all.bridge)}};
}

}  // namespace plslam::launcher
