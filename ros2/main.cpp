// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <vector>

#include "core/process/argument_vector.h"
#include "core/process/process.h"
#include "ros2/arguments.h"
#include "ros2/dds/list_topics.h"
#include "ros2/node/ros2_node.h"

int main(int argc, char** argv) {
  std::vector<std::string> arguments = plslam::ros2::WithoutRosArguments({argv, argv + argc});
  if (std::find(arguments.begin(), arguments.end(), "--topics") != arguments.end()) return plslam::ros2::ListTopics();
  return plslam::bus::RunProcess(static_cast<int>(arguments.size()), plslam::ArgumentVector(arguments).data(),
                                 plslam::ros2::Ros2Spec());
}
