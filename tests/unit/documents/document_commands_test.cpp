// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/documents/document_commands.h"

#include <gmock/gmock.h>

namespace plslam::test {
namespace {

using testing::ElementsAre;

TEST(DocumentCommands, AreFromShellBlocks) {
  const auto blocks = CommandBlocks(
      "text\n```sh\na --b 'c # d'   # comment\n# only a comment\n\nlong \\\n  --one\n```\n```\nnot run\n```\n"
      "```yaml\nkey: 1\n```\n```sh\n```\n```sh\nlast\n```\n");
  ASSERT_EQ(blocks.size(), 2U);
  ASSERT_EQ(blocks[0].size(), 2U);
  EXPECT_EQ(blocks[0][0].text, "a --b 'c # d'");
  EXPECT_EQ(blocks[0][0].line, 3);
  EXPECT_EQ(blocks[0][1].text, "long --one");
  EXPECT_EQ(blocks[0][1].line, 6);
  EXPECT_EQ(blocks[1][0].text, "last");
}

TEST(DocumentCommands, StandIns) {
  const auto stand_in = [](const std::string& command) { return WithStandIns(command, false, 9000); };
  EXPECT_EQ(stand_in("plslam run /data/kitti/03 --out out/kitti_03"),
            "plslam run 'synthetic:room?frames=6&size=376x240' --out out/kitti_03");
  EXPECT_EQ(stand_in("plslam run \"synthetic:whitewall?seed=3\" --start 100"),
            "plslam run 'synthetic:whitewall?frames=6&size=376x240' --start 2");
  EXPECT_EQ(stand_in("plslam doctor --url udpm://239.255.76.67:7667?ttl=1"),
            "plslam doctor --url udpm://239.255.76.67:9000?ttl=0");
  EXPECT_EQ(WithStandIns("build/release/bin/player ~/MH_01_easy", true, 1),
            "build/release/bin/player 'synthetic:room?frames=6&size=376x240' --exit");
  EXPECT_TRUE(IsEndless("build/release/bin/vo_process --set a=b", true));
  EXPECT_TRUE(IsEndless("player x", false));
  EXPECT_FALSE(IsEndless("player x", true));
  EXPECT_FALSE(IsEndless("plslam run x", true));
}

TEST(DocumentCommands, EveryReasonNotToRunOneIsNeeded) { EXPECT_THAT(IdleRows(), ElementsAre()); }

}  // namespace
}  // namespace plslam::test
