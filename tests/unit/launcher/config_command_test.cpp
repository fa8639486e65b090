// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <CLI/CLI.hpp>

#include "core/config/config.h"
#include "tools/plslam/all_options.h"
#include "tools/plslam/commands.h"

namespace plslam::launcher {
namespace {

using testing::HasSubstr;

/// Returns the output of `plslam ARGUMENTS`.
std::string Printed(const std::string& arguments) {
  CLI::App app;
  Command command;
  AddConfigCommand(&app, &command);
  app.parse(arguments);
  testing::internal::CaptureStdout();
  try {
    command();
  } catch (...) {
    testing::internal::GetCapturedStdout();
    throw;
  }
  return testing::internal::GetCapturedStdout();
}

TEST(ConfigCommand, PrintsAValidConfigurationFile) {
  const std::string text = Printed("config --set vo.features.orb.max_points=813 --set viewer.overlay_every=7");
  EXPECT_THAT(text, HasSubstr("# Odometry (PL-SLAM §IV).\nvo:\n"));
  EXPECT_THAT(text, HasSubstr("# a picture of the tracked features"));
  const Config config = Config::FromString(text, "printed");
  AllOptions read;
  for (const OptionSection& section : SectionsOf(read)) config.ReadFields(section.name, section.fields);
  EXPECT_EQ(read.vo.features.orb.max_points, 813);
  EXPECT_EQ(read.viewer.overlay_every, 7);
  EXPECT_EQ(read.loop.vocabularies.points, loop::LoopOptions().vocabularies.points);
}

TEST(ConfigCommand, RefusesUnknownKeys) {
  try {
    Printed("config --set vo.features.orb.max_pints=813");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("max_points"));
  }
}

}  // namespace
}  // namespace plslam::launcher
