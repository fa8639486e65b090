// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <vector>

#include "core/process/process.h"
#include "ros2/arguments.h"
#include "ros2/dds/list_topics.h"
#include "ros2/node/ros2_node.h"

int main(int argc, char** argv) {
  std::vector<std::string> arguments = plslam::ros2::WithoutRosArguments({argv, argv + argc});
  if (std::find(arguments.begin(), arguments.end(), "--topics") != arguments.end()) return plslam::ros2::ListTopics();
  std::vector<char*> words;
  words.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  return plslam::bus::RunProcess(static_cast<int>(arguments.size()), words.data(), plslam::ros2::Ros2Spec());
}
