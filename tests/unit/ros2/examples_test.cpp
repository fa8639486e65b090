// SPDX-License-Identifier: BSD-3-Clause
// The examples for ROS itself, which is not installed here: the names that they use are ours.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cstdlib>
#include <regex>
#include <set>
#include <string>

#include "core/config/config.h"
#include "core/ros/ros_topics.h"
#include "ros2/options.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam::ros2 {
namespace {

std::string Example(const std::string& name) { return ReadText(test::SourceFolder() / "ros2/examples" / name); }

TEST(Ros2Examples, RvizShowsOurTopicsWithTheirQos) {
  int n_topics = 0;
  for (const YAML::Node& display : YAML::Load(Example("plslam.rviz"))["Visualization Manager"]["Displays"]) {
    if (!display["Topic"]) continue;
    const auto name = display["Topic"]["Value"].as<std::string>();
    const RosTopic* found = nullptr;
    for (const RosTopic& row : RosTopics()) {
      if (row.is_live && "/plslam" + std::string(row.name) == name) found = &row;
    }
    ASSERT_NE(found, nullptr) << name;
    const std::string durability = found->qos == RosQos::kLatched ? "Transient Local" : "Volatile";
    EXPECT_EQ(display["Topic"]["Durability Policy"].as<std::string>(), durability) << name;
    // The class of a display has the name of its message, except for the grid.
    std::string type(found->type.substr(found->type.rfind('/') + 1));
    if (type == "OccupancyGrid") type = "Map";
    EXPECT_EQ(display["Class"].as<std::string>(), "rviz_default_plugins/" + type) << name;
    ++n_topics;
  }
  EXPECT_EQ(n_topics, 7);
}

TEST(Ros2Examples, LaunchFileSetsOptionsThatExist) {
  Ros2Options options;
  const YAML::Node known = YAML::Load(ToYaml("ros2", options))["ros2"];
  const std::string text = Example("plslam.launch.py");
  const std::regex key(R"("ros2\.(\w+)=")");
  int n_keys = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), key), end; it != end; ++it, ++n_keys) {
    EXPECT_TRUE(known[(*it)[1].str()]) << (*it)[1];
  }
  EXPECT_EQ(n_keys, 2);
  const std::string compiled = "python3 -c \"import ast; ast.parse(open('" +
                               (test::SourceFolder() / "ros2/examples/plslam.launch.py").string() + "').read())\"";
  EXPECT_EQ(std::system(compiled.c_str()), 0);
}

}  // namespace
}  // namespace plslam::ros2
