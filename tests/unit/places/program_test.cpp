// SPDX-License-Identifier: BSD-3-Clause
// The programs train_vocabulary and `evaluate places`, on small built-in worlds.
#include <gmock/gmock.h>

#include <array>
#include <nlohmann/json.hpp>

#include "core/places/vocabulary.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"

namespace plslam {
namespace {

using test::ShellResult;
using testing::HasSubstr;

ShellResult Start(const ScratchFolder& folder, const std::string& program, const std::string& arguments) {
  return test::Shell(folder, (test::BinaryFolder() / program).string() + " " + arguments);
}

TEST(PlacePrograms, TrainAndEvaluateOnABuiltInWorld) {
  const ScratchFolder folder;
  const std::string world = "'synthetic:room?size=320x240&rate=1&loops=2'";
  for (const std::string kind : {"points", "lines"}) {
    const ShellResult run =
        Start(folder, "train_vocabulary", "--kind " + kind + " --depth 3 --out " + folder.Path(kind) + " " + world);
    EXPECT_EQ(run.exit_code, 0) << run.error;
    EXPECT_THAT(run.out, HasSubstr("31 images"));
    EXPECT_THAT(run.out, HasSubstr(Vocabulary::Load(folder.Path(kind)).checksum()));
  }
  const ShellResult run =
      Start(folder, "evaluate",
            "places " + world + " --points " + folder.Path("points") + " --lines " + folder.Path("lines") +
                " --out " + folder.Path("p") + " --json " + folder.Path("j"));
  EXPECT_EQ(run.exit_code, 0) << run.error;
  EXPECT_THAT(run.out, HasSubstr("adaptive"));
  const auto json = nlohmann::json::parse(ReadText(folder.Path("j")));
  EXPECT_GT(json["sequences"][0]["merges"]["adaptive"]["best_match"]["area"].get<double>(), 0.99);
  EXPECT_EQ(ReadText(folder.Path("p/synthetic_room_size_320x240_rate_1_loops_2_similarity.png")).substr(1, 3), "PNG");
  EXPECT_EQ(ReadText(folder.Path("p/synthetic_room_size_320x240_rate_1_loops_2_precision_recall.png")).substr(1, 3),
            "PNG");
}

TEST(PlacePrograms, DefaultVocabulariesAreFoundFromAnyFolder) {
  const ScratchFolder folder;
  const ShellResult run =
      test::Shell(folder, "cd " + folder.Path("") + " && " + (test::BinaryFolder() / "evaluate").string() +
                              " places 'synthetic:room?size=160x120&frames=6' --json j");
  EXPECT_EQ(run.exit_code, 0) << run.error;
  EXPECT_EQ(nlohmann::json::parse(ReadText(folder.Path("j")))["sequences"].size(), 1U);
}

TEST(PlacePrograms, ErrorsAreOneSentenceAndExitCodeOne) {
  const ScratchFolder folder;
  const std::string out = " --out " + folder.Path("v") + " ";
  const std::string config = (test::SourceFolder() / "config").string();
  const std::vector<std::array<std::string, 3>> cases{
      {"train_vocabulary", "--kind points" + out + "nowhere", "nowhere"},
      {"train_vocabulary", "--kind corners" + out + "synthetic:room", "corners"},
      {"train_vocabulary", "--kind points" + out + "'synthetic:room?frames=0'", "frames"},
      {"train_vocabulary", "--kind points --out " + folder.Path("no/v") + " 'synthetic:room?frames=1&size=160x120'",
       "no/v"},
      {"train_vocabulary", "--kind points", "--out is required"},
      {"evaluate", "places synthetic:room --points nothing", "vocabulary nothing cannot be read"},
      {"evaluate",
       "places synthetic:room --points " + config + "/lbd.vocabulary --lines " + config + "/orb.vocabulary",
       "a vocabulary of lines was given where one of points is needed"},
      {"evaluate", "places", "datasets is required"},
      {"evaluate",
       "places synthetic:moon --points " + config + "/orb.vocabulary --lines " + config + "/lbd.vocabulary", "moon"}};
  for (const auto& [program, arguments, sentence] : cases) {
    const ShellResult run = Start(folder, program, arguments);
    EXPECT_EQ(run.exit_code, 1) << arguments;
    EXPECT_THAT(run.error, HasSubstr(sentence)) << arguments;
  }
}

}  // namespace
}  // namespace plslam
