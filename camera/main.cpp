// SPDX-License-Identifier: BSD-3-Clause
#include "camera/command_line.h"
#include "camera/node/camera_node.h"
#include "core/process/process.h"
#include "core/run/process_names.h"

int main(int argc, char** argv) {
  plslam::camera::CameraCommandLine command_line;
  plslam::bus::ProcessSpec spec;
  spec.name = plslam::process_name::kCamera;
  spec.description = "Publishes the images of two live cameras, or of two video files, on the bus.";
  spec.examples =
      "  camera rig.yaml\n"
      "  camera rig.yaml --print-pipeline\n"
      "  camera videos.yaml --pace lockstep --exit";
  spec.add_options = [&](void* app) { command_line.AddTo(app); };
  spec.make_node = [&](plslam::bus::Process& process, const plslam::Config& config) {
    return std::make_shared<plslam::camera::CameraNode>(process, command_line.Options(config));
  };
  spec.results = {{"frames.sent", "frames sent"}, {"frames.missing", "missing"}};
  return plslam::bus::RunProcess(argc, argv, spec);
}
