// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/config/config.h"
#include "tests/unit/config/test_options.h"

namespace plslam {
namespace {

using test::OuterOptions;

OuterOptions Read(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  Config config = Config::FromString(yaml, "rig.yaml");
  for (const std::string& text : overrides) config.Override(text);
  OuterOptions options;
  config.Read("vo", options);
  return options;
}

/// Returns the sentence with which `yaml` is rejected; empty if it is accepted.
std::string Refusal(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  try {
    Read(yaml, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Config, EmptyFileKeepsDefaults) {
  for (const char* yaml : {"", "# only a comment\n", "vo:\n", "vo: {}\n", "vo:\n  inner:\n"}) {
    const OuterOptions options = Read(yaml);
    EXPECT_EQ(options.max_points, 1000) << yaml;
    EXPECT_EQ(options.inner.scale, 1.2) << yaml;
  }
}

TEST(Config, ReadsEveryTypeOfField) {
  const OuterOptions o = Read(R"(
vo:
  enabled: false
  max_points: 12
  seed: 123456789012
  score: fast
  folder: "a b: c"
  inner:
    scale: 1.5
    sigmas: [3, 4.5, 1e-3]
)");
  EXPECT_FALSE(o.enabled);
  EXPECT_EQ(o.max_points, 12);
  EXPECT_EQ(o.seed, 123456789012);
  EXPECT_EQ(o.score, test::Corners::kFast);
  EXPECT_EQ(o.folder, "a b: c");
  EXPECT_EQ(o.inner.scale, 1.5);
  EXPECT_THAT(o.inner.sigmas, testing::ElementsAre(3.0, 4.5, 1e-3));
}

TEST(Config, LaterOverrideWins) {
  const OuterOptions o = Read("vo: {max_points: 1}", {"vo.max_points=2", "vo.max_points=3", "vo.inner.sigmas=[9]",
                                                      "vo.folder=udpm://1:2?a=b"});
  EXPECT_EQ(o.max_points, 3);
  EXPECT_THAT(o.inner.sigmas, testing::ElementsAre(9.0));
  EXPECT_EQ(o.folder, "udpm://1:2?a=b");
  EXPECT_EQ(Read("vo: {folder: x}", {"vo.folder="}).folder, "");
}

TEST(Config, OtherSectionsAreIgnored) { EXPECT_EQ(Refusal("player: {rubbish: 1}\nvoice: {x: 1}\n"), ""); }

TEST(Config, UnknownKeyNamesFileLineAndNearestKey) {
  EXPECT_EQ(Refusal("vo:\n  seed: 1\n  inner:\n    sclae: 1.5\n"),
            "rig.yaml:4: unknown key 'vo.inner.sclae'; the nearest known one is 'vo.inner.scale'");
  EXPECT_EQ(Refusal("", {"vo.max_point=5"}),
            "override 'vo.max_point=5': unknown key 'vo.max_point'; the nearest known one is 'vo.max_points'");
}

TEST(Config, UnknownSectionNamesTheNearest) {
  static constexpr std::string_view kKnown[] = {"bus", "vo"};
  const Config config = Config::FromString("bus: {}\nvoo: {x: 1}\n", "rig.yaml");
  EXPECT_THAT(
      [&] { config.RequireSections(kKnown); },
      testing::ThrowsMessage<ConfigError>("rig.yaml:2: unknown section 'voo'; the nearest known one is 'vo'"));
  EXPECT_NO_THROW(Config::FromString("bus: {}\nvo: {x: 1}\n", "rig.yaml").RequireSections(kKnown));
}

TEST(Config, DuplicateKeyIsRefused) {
  EXPECT_EQ(Refusal("vo: &all {inner: *all}\n"), "rig.yaml:1: keys are nested more than 16 deep");
  EXPECT_EQ(Refusal("vo:\n  seed: 1\n  seed: 1\n"), "rig.yaml:3: key 'vo.seed' is repeated");
  EXPECT_EQ(Refusal("vo: {inner: {scale: 1.5}}\nvo: {seed: 1}\n"), "rig.yaml:2: key 'vo' is repeated");
  EXPECT_EQ(Refusal("vo:\n  inner: {scale: 1.5}\n  inner.scale: 1.6\n"),
            "rig.yaml:3: key 'vo.inner.scale' is repeated");
}

TEST(Config, WrongTypeIsRefused) {
  EXPECT_EQ(Refusal("vo: {max_points: many}"),
            "rig.yaml:1: key 'vo.max_points' is 'many'; it must be a whole number");
  EXPECT_EQ(Refusal("vo: {max_points: 1.5}"), "rig.yaml:1: key 'vo.max_points' is '1.5'; it must be a whole number");
  EXPECT_EQ(Refusal("vo: {max_points: 99999999999}"),
            "rig.yaml:1: key 'vo.max_points' is 99999999999; it must be in [0, 20000]");
  EXPECT_EQ(Refusal("vo: {max_points: [1]}"), "rig.yaml:1: key 'vo.max_points' is a list; it must be a whole number");
  EXPECT_EQ(Refusal("vo: {max_points: }"), "rig.yaml:1: key 'vo.max_points' has no value; it must be a whole number");
  EXPECT_EQ(Refusal("vo: {enabled: maybe}"), "rig.yaml:1: key 'vo.enabled' is 'maybe'; it must be true or false");
  EXPECT_EQ(Refusal("vo: {inner: 5}"), "rig.yaml:1: key 'vo.inner' is a group of keys and has no value");
  EXPECT_EQ(Refusal("vo: {inner: {sigmas: 5}}"),
            "rig.yaml:1: key 'vo.inner.sigmas' must be a list of numbers, like [1, 2.5]");
  EXPECT_EQ(Refusal("vo: 5"), "rig.yaml:1: key 'vo' is a group of keys and has no value");
  EXPECT_NE(Refusal("vo: {seed: {a: 1}}"), "");
  EXPECT_NE(Refusal("vo: {inner: {sigmas: [[1], 2]}}"), "");
}

TEST(Config, OutOfBoundsNamesTheBounds) {
  EXPECT_EQ(Refusal("vo: {max_points: -1}"), "rig.yaml:1: key 'vo.max_points' is -1; it must be in [0, 20000]");
  EXPECT_EQ(Refusal("vo: {inner: {scale: nan}}"), "rig.yaml:1: key 'vo.inner.scale' is nan; it must be in [1.05, 2]");
  EXPECT_EQ(Refusal("vo: {inner: {sigmas: [1, 101]}}"),
            "rig.yaml:1: key 'vo.inner.sigmas' is 101; it must be in [0, 100]");
  EXPECT_EQ(Refusal("vo: {score: sift}"), "rig.yaml:1: key 'vo.score' is 'sift'; it must be one of harris, fast");
  EXPECT_EQ(Refusal("vo: {max_points: 20000}"), "");
}

TEST(Config, BrokenYamlNamesTheLine) {
  EXPECT_THAT(Refusal("vo:\n  seed: [1\n"), testing::StartsWith("rig.yaml:"));
  EXPECT_EQ(Refusal("- a\n- b\n"), "rig.yaml:1: must be a map of sections");
  EXPECT_EQ(Refusal("vo: {}\n---\nvo: {}\n"), "rig.yaml: has more than one YAML document");
  EXPECT_NE(Refusal("? [a, b]\n: 1\n"), "");
  EXPECT_EQ(Refusal("vo:\n\tseed: 1\n"), "rig.yaml:2: is indented by a tab; YAML requires spaces");
}

TEST(Config, BinaryFileDoesNotReachTheTerminal) {
  const std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  EXPECT_THAT(Refusal(png), testing::StartsWith("rig.yaml: is not YAML, but binary: \\x89PNG"));
  EXPECT_THAT(Refusal("vo: {seed: \x1b[2J}"), testing::Not(testing::HasSubstr("\x1b")));
}

TEST(Config, BadOverrideNamesTheExpectedForm) {
  for (const char* text : {"vo", "vo=1", "max_points=3", ".x=1", "vo.=1", "=1", ""}) {
    EXPECT_THAT(Refusal("", {text}), testing::HasSubstr("must be SECTION.KEY=VALUE")) << text;
  }
}

TEST(Config, UnreadableFileIsNamed) {
  EXPECT_THAT([] { Config::FromFile("/nonexistent/rig.yaml"); },
              testing::ThrowsMessage<ConfigError>(testing::StartsWith("/nonexistent/rig.yaml: cannot be read")));
  EXPECT_THROW(Config::FromFile(std::filesystem::temp_directory_path()), ConfigError);
}

}  // namespace

namespace {

using test::OuterOptions;

TEST(ConfigPrinting, YamlReadsBackTheSame) {
  OuterOptions options;
  options.enabled = false;
  options.seed = 999999999999999;
  options.folder = "with \"quotes\", back\\slash: and\nline";
  options.inner.scale = 1.1 + 0.1;
  options.inner.sigmas = {1.0 / 3.0, 0.0, 1e-17};
  for (const bool comments : {false, true}) {
    const std::string yaml = ToYaml("vo", options, comments);
    OuterOptions again;
    Config::FromString(yaml, "printed").Read("vo", again);
    EXPECT_EQ(again.enabled, options.enabled) << yaml;
    EXPECT_EQ(again.seed, options.seed) << yaml;
    EXPECT_EQ(again.folder, options.folder) << yaml;
    EXPECT_EQ(again.inner.scale, options.inner.scale) << yaml;
    EXPECT_EQ(again.inner.sigmas, options.inner.sigmas) << yaml;
    EXPECT_EQ(ToYaml("vo", again, comments), yaml);
  }
}

TEST(ConfigPrinting, YamlIsNested) {
  OuterOptions options;
  EXPECT_EQ(ToYaml("vo", options), R"(vo:
  enabled: true
  max_points: 1000
  seed: 7
  score: "harris"
  folder: ""
  inner:
    scale: 1.2
    sigmas: [1, 2.5]
)");
}

TEST(ConfigPrinting, MarkdownHasARowForEachField) {
  OuterOptions options;
  EXPECT_EQ(ToMarkdown("vo", options), R"(| key | default | allowed | meaning |
|---|---|---|---|
| `vo.enabled` | `true` |  | in use |
| `vo.max_points` | `1000` | 0 to 20000 | points kept |
| `vo.seed` | `7` | 0 to 1000000000000000 | seed |
| `vo.score` | `"harris"` | one of harris, fast | what ranks the corners |
| `vo.folder` | `""` |  | where |
| `vo.inner.scale` | `1.2` | 1.05 to 2 | size ratio |
| `vo.inner.sigmas` | `[1, 2.5]` | 0 to 100 | deviations |
)");
}

}  // namespace
}  // namespace plslam
