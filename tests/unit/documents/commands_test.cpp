#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/documents/document_commands.h"
#include "tests/unit/documents/document_world.h"

namespace plslam::test {
namespace {

/// One test for each document, so that one that is new takes part by itself.
class Commands : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(Commands, OfTheDocumentWork) {
  std::ifstream file(GetParam());
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  DocumentWorld world;
  for (const CommandBlock& block : CommandBlocks(text)) EXPECT_EQ(world.Run(block), "") << GetParam();
}

INSTANTIATE_TEST_SUITE_P(Documents, Commands, testing::ValuesIn(DocumentsWithCommands()),
                         [](const auto& document) { return document.param.stem().string(); });

}  // namespace
}  // namespace plslam::test
