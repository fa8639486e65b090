// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "core/ros/ros_definitions.h"
#include "core/ros/ros_topics.h"
#include "ros2/domain.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam::ros2 {
namespace {

using testing::HasSubstr;

TEST(Ros2Names, TopicsAndTypesInDds) {
  EXPECT_EQ(DdsTopicName("/stereo/left/image_raw"), "rt/stereo/left/image_raw");
  EXPECT_EQ(RosTopicName("rt/odom"), "/odom");
  EXPECT_EQ(RosTopicName("rq/plslam/saveRequest"), "");
  EXPECT_EQ(DdsTypeName("nav_msgs/msg/Odometry"), "nav_msgs::msg::dds_::Odometry_");
  EXPECT_EQ(RosTypeName("sensor_msgs::msg::dds_::Image_"), "sensor_msgs/msg/Image");
  EXPECT_EQ(RosTypeName("Other::Type"), "Other::Type");
}

TEST(Ros2Names, ServiceIsTwoTopics) {
  const ServiceNames names = DdsServiceNames("/plslam/save", "std_srvs/srv/Trigger");
  EXPECT_EQ(names.request, "rq/plslam/saveRequest");
  EXPECT_EQ(names.reply, "rr/plslam/saveReply");
  EXPECT_EQ(names.request_type, "std_srvs::srv::dds_::Trigger_Request_");
  EXPECT_EQ(names.reply_type, "std_srvs::srv::dds_::Trigger_Response_");
}

TEST(Ros2Names, NamespacesAndInvalidNames) {
  EXPECT_EQ(InNamespace("/robot", "odom"), "/robot/odom");
  EXPECT_EQ(InNamespace("", "odom"), "/odom");
  EXPECT_EQ(InNamespace("/robot", "/tf"), "/tf");
  EXPECT_EQ(TopicNameComplaint("/left/image_raw"), "");
  EXPECT_THAT(TopicNameComplaint("left"), HasSubstr("does not begin with /"));
  EXPECT_THAT(TopicNameComplaint("/left/"), HasSubstr("ends with /"));
  EXPECT_THAT(TopicNameComplaint("/le ft"), HasSubstr("another character"));
}

TEST(Ros2Names, CameraFrameHasTheBodysPrefix) {
  EXPECT_EQ(CameraFrameOf("base_link", ""), "camera_left");
  EXPECT_EQ(CameraFrameOf("one/base_link", ""), "one/camera_left");
  EXPECT_EQ(CameraFrameOf("one/base_link", "eye"), "eye");
}

Domain DomainWith(const std::map<std::string, std::string>& variables) {
  return DomainOf([&](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
}

TEST(Ros2Domain, EnvironmentOfRos) {
  EXPECT_EQ(DomainWith({}).id, 0);
  EXPECT_FALSE(DomainWith({}).loopback_only);
  EXPECT_EQ(DomainWith({{"ROS_DOMAIN_ID", "42"}}).id, 42);
  EXPECT_TRUE(DomainWith({{"ROS_LOCALHOST_ONLY", "1"}}).loopback_only);
  EXPECT_TRUE(DomainWith({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"}}).loopback_only);
  for (const char* wrong : {"x", "-1", "233", "7 ", "99999999999999999999"}) {
    EXPECT_THROW(DomainWith({{"ROS_DOMAIN_ID", wrong}}), std::runtime_error) << wrong;
  }
  EXPECT_THROW(DomainWith({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}}), std::runtime_error);
}

TEST(Ros2Domain, UserHasTheLastWord) {
  const std::string text = CycloneConfiguration({.id = 0, .loopback_only = true}, "file:///mine.xml");
  EXPECT_THAT(text, HasSubstr("127.0.0.1"));
  EXPECT_TRUE(text.ends_with(",file:///mine.xml"));
}

/// Members of each structure of the IDL file, by the name of the type in ROS: "double x".
std::map<std::string, std::vector<std::string>> Structures() {
  std::string text = ReadText(test::SourceFolder() / "ros2/idl/ros_types.idl");
  std::map<std::string, std::vector<std::string>> structures;
  static const std::regex kModule(R"(module (\w+) \{ module msg)"), kStruct(R"(struct (\w+)_ \{([^}]*)\};)");
  std::vector<std::pair<std::ptrdiff_t, std::string>> modules;
  for (std::sregex_iterator m(text.begin(), text.end(), kModule), end; m != end; ++m) {
    modules.emplace_back(m->position(), (*m)[1]);
  }
  for (std::sregex_iterator s(text.begin(), text.end(), kStruct), end; s != end; ++s) {
    const auto after =
        std::find_if(modules.begin(), modules.end(), [&](const auto& m) { return m.first > s->position(); });
    std::istringstream members((*s)[2]);
    std::vector<std::string>& list = structures[std::prev(after)->second + "/" + std::string((*s)[1])];
    for (std::string member; std::getline(members, member, ';');) {
      member = std::regex_replace(member, std::regex(R"(^\s+|\s+$)"), "");
      if (!member.empty()) list.push_back(std::regex_replace(member, std::regex(R"(\s+)"), " "));
    }
  }
  return structures;
}

/// A member as the definitions of ROS write it.
std::string InRos(const std::string& member) {
  static const std::vector<std::pair<std::regex, std::string>> kWords{
      {std::regex(R"((\w+)::msg::dds_::(\w+)_)"), "$1/$2"},
      {std::regex(R"(sequence<([^>]+)>)"), "$1[]"},
      {std::regex(R"(unsigned long)"), "uint32"},
      {std::regex(R"(\blong\b)"), "int32"},
      {std::regex(R"(\bdouble\b)"), "float64"},
      {std::regex(R"(\bfloat\b)"), "float32"},
      {std::regex(R"(\bboolean\b)"), "bool"},
      {std::regex(R"(\boctet\b)"), "uint8"},
      {std::regex(R"(^(\S+) (\w+)(\[\d+\])$)"), "$1$3 $2"}};
  std::string text = member;
  for (const auto& [from, to] : kWords) text = std::regex_replace(text, from, to);
  return text;
}

// DDS, and the writers of CDR, have the same types.
TEST(Ros2Names, TypesOfTheIdlAreThoseOfTheTable) {
  const auto structures = Structures();
  std::set<std::string> compared;
  for (const RosTopic& topic : RosTopics()) {
    const std::string definition = RosDefinition(std::string(topic.type));
    std::istringstream parts(
        std::regex_replace("MSG: " + std::string(topic.type) + "\n" + definition, std::regex("=+\n"), ""));
    std::string name;
    std::map<std::string, std::vector<std::string>> expected;
    for (std::string line; std::getline(parts, line);) {
      if (line.starts_with("MSG: ")) {
        name = std::regex_replace(line.substr(5), std::regex("/msg/"), "/");
      } else {
        expected[name].push_back(std::regex_replace(line, std::regex("^byte "), "uint8 "));
      }
    }
    for (const auto& [type, members] : expected) {
      ASSERT_TRUE(structures.contains(type)) << type << " is not in ros_types.idl";
      std::vector<std::string> ours;
      for (const std::string& member : structures.at(type)) ours.push_back(InRos(member));
      EXPECT_EQ(ours, members) << type;
      compared.insert(type);
    }
  }
  EXPECT_GT(compared.size(), 20U);
}

}  // namespace
}  // namespace plslam::ros2
