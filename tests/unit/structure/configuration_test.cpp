#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/config/config.h"
#include "core/config/sections.h"
#include "tests/support/data_folder.h"
#include "tests/unit/structure/configuration_reference.h"
#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

TEST(Configuration, ReferenceIsUpToDate) {
  EXPECT_EQ(test::ReadText(test::SourceFolder() / "docs/configuration.md"), test::ConfigurationReference())
      << "run scripts/document";
}

TEST(Configuration, RigFilesAreCompleteAndUpToDate) {
  for (const auto& rig : test::RigConfigurations()) {
    EXPECT_EQ(test::ReadText(test::SourceFolder() / "config" / (rig.name + ".yaml")), test::RigYaml(rig))
        << "run scripts/document";
  }
}

TEST(Configuration, RigFilesHaveKnownSectionsOnly) {
  for (const auto& entry : std::filesystem::directory_iterator(test::SourceFolder() / "config")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(Config::FromFile(entry.path()).RequireSections(kConfigSections)) << entry.path();
  }
}

}  // namespace
}  // namespace plslam
