// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/config/config.h"
#include "tests/support/data_folder.h"
#include "tests/unit/structure/configuration_reference.h"
#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

TEST(Configuration, ReferenceIsUpToDate) {
  EXPECT_EQ(test::ReadText(test::SourceFolder() / "docs/configuration.md"), test::ConfigurationReference())
      << "run scripts/document";
}

TEST(Configuration, FileIsCompleteAndUpToDate) {
  const std::filesystem::path file = test::SourceFolder() / "config/plslam.yaml";
  EXPECT_EQ(test::ReadText(file), test::ConfigurationFile()) << "run scripts/document";
  EXPECT_NO_THROW(Config::FromFile(file).RequireSections(kConfigSections));
}

}  // namespace
}  // namespace plslam
