// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/command_line.h"
#include "adapter/node/adapter_node.h"
#include "core/process/process.h"
#include "core/run/process_names.h"

int main(int argc, char** argv) {
  plslam::adapter::AdapterCommandLine command_line;
  plslam::bus::ProcessSpec spec;
  spec.name = plslam::process_name::kAdapter;
  spec.description = "Connects a robot that uses LCM: receives its stereo images, publishes poses and the map.";
  spec.examples =
      "  adapter --images CAMERA --camera camera.yaml\n"
      "  adapter --left '/left#sensor_msgs.Image' --right '/right#sensor_msgs.Image'\n"
      "  adapter --images CAMERA --camera camera.yaml --foreign-url 'udpm://239.255.76.67:7667?ttl=1' --url "
      "'udpm://239.255.76.67:7700?ttl=0'";
  spec.add_options = [&](void* app) { command_line.AddTo(app); };
  spec.make_node = [&](plslam::bus::Process& process, const plslam::Config& config) {
    return std::make_shared<plslam::adapter::AdapterNode>(process, command_line.Options(config));
  };
  spec.waits_for = "images";
  spec.results = {{"frames.sent", "frames"},
                  {"frames.unpaired", "unpaired"},
                  {"frames.rejected", "rejected"},
                  {"poses.sent", "poses"}};
  return plslam::bus::RunProcess(argc, argv, spec);
}
