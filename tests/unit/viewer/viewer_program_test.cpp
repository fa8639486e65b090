// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cstdlib>

#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam::viewer {
namespace {

using testing::HasSubstr;

int RunViewer(const ScratchFolder& folder, const std::string& arguments) {
  const std::string command = (test::BinaryFolder() / "viewer_headless").string() + " --url memq:// " + arguments +
                              " >" + folder.Path("stdout") + " 2>" + folder.Path("stderr");
  return WEXITSTATUS(std::system(command.c_str()));  // NOLINT: the test runs the program
}

TEST(ViewerProgram, UnwritableFolderIsOneSentenceAndExitCodeOne) {
  const ScratchFolder folder;
  const std::string file = folder.Write("file", "");
  EXPECT_EQ(RunViewer(folder, "--out " + file + "/out"), 1);
  EXPECT_THAT(ReadText(folder.Path("stderr")),
              HasSubstr("viewer: error: " + file + "/out: the folder cannot be created"));
}

TEST(ViewerProgram, ResultsOfAnEarlierRunAreKept) {
  const ScratchFolder folder;
  folder.Write("trajectory.tum", "0 0 0 0 0 0 0 1\n");
  EXPECT_EQ(RunViewer(folder, "--out " + folder.Path("")), 1);
  EXPECT_THAT(ReadText(folder.Path("stderr")), HasSubstr("has results of an earlier run (trajectory.tum)"));
  EXPECT_EQ(ReadText(folder.Path("trajectory.tum")), "0 0 0 0 0 0 0 1\n");
}

TEST(ViewerProgram, BadOptionsAreNamed) {
  const ScratchFolder folder;
  EXPECT_EQ(RunViewer(folder, "--overlay-every -3"), 1);
  EXPECT_THAT(ReadText(folder.Path("stderr")), HasSubstr("--overlay-every"));
  EXPECT_EQ(RunViewer(folder, "--set viewer.overlays=3"), 1);
  EXPECT_THAT(ReadText(folder.Path("stderr")), HasSubstr("overlay_every")) << "the nearest known key";
}

TEST(ViewerProgram, InvalidPortsAreRefused) {
  const ScratchFolder folder;
  EXPECT_EQ(RunViewer(folder, "--serve 0"), 1);
  EXPECT_THAT(ReadText(folder.Path("stderr")), HasSubstr("--serve"));
  EXPECT_EQ(RunViewer(folder, "--serve 70000"), 1);
  EXPECT_THAT(ReadText(folder.Path("stderr")), HasSubstr("70000"));
}

TEST(ViewerProgram, HelpShowsItsOptions) {
  const ScratchFolder folder;
  EXPECT_EQ(RunViewer(folder, "--help"), 0);
  EXPECT_THAT(ReadText(folder.Path("stdout")), HasSubstr("--overlay-every"));
}

}  // namespace
}  // namespace plslam::viewer
