// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <fstream>

#include "core/bus/transport/transport.h"
#include "tests/unit/documents/document_commands.h"
#include "tests/unit/documents/document_world.h"

namespace plslam::test {
namespace {

/// One test for each document, so that one that is new takes part by itself.
class Commands : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(Commands, CommandsOfTheDocumentWork) {
  std::ifstream file(GetParam());
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::string reason;
  if (!bus::MulticastWorks("", &reason)) GTEST_SKIP() << "processes by hand need multicast: " << reason;
  DocumentWorld world;
  for (const CommandBlock& block : CommandBlocks(text)) EXPECT_EQ(world.Run(block), "") << GetParam();
}

INSTANTIATE_TEST_SUITE_P(Documents, Commands, testing::ValuesIn(DocumentsWithCommands()),
                         [](const auto& document) { return document.param.stem().string(); });

TEST(DocumentWorld, FailureNamesLineAndOutput) {
  DocumentWorld world;
  EXPECT_THAT(world.Run({{"plslam run nowhere --out out/x", 7}}),
              testing::AllOf(testing::HasSubstr("line 7: plslam run nowhere"), testing::HasSubstr("nowhere")));
  EXPECT_THAT(world.Run({{"vo_process --no-such-option", 8}}), testing::HasSubstr("line 8"));
  EXPECT_EQ(world.Run({{"plslam processes", 9}}), "");
}

}  // namespace
}  // namespace plslam::test
