// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "core/config/config.h"
#include "tests/unit/config/test_options.h"

namespace plslam {
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
