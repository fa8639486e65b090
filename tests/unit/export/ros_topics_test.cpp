// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/ros/ros_definitions.h"
#include "core/ros/ros_topics.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

TEST(RosTopics, EveryRowIsCompleteAndDocumented) {
  const std::string document = ReadText(test::SourceFolder() / "docs/exports.md");
  std::set<std::string_view> names;
  for (const RosTopic& topic : RosTopics()) {
    SCOPED_TRACE(topic.name);
    EXPECT_TRUE(names.insert(topic.name).second);
    EXPECT_TRUE(topic.name.starts_with("/"));
    EXPECT_NO_THROW(RosDefinition(std::string(topic.type)));
    EXPECT_FALSE(topic.meaning.empty());
    EXPECT_THAT(document, testing::HasSubstr("`" + std::string(topic.name) + "`"));
  }
}

}  // namespace
}  // namespace plslam
