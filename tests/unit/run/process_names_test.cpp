// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/process_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

std::string Definition(const std::string& message) {
  return ReadText(test::SourceFolder() / "lcmtypes" / (message + ".lcm"));
}

TEST(ProcessNames, StatesAndVerbsAreDocumentedInMessages) {
  for (const char* state : process_state::kAll) {
    EXPECT_THAT(Definition("status_t"), testing::HasSubstr('"' + std::string(state) + '"'));
  }
  for (const char* verb : command_verb::kAll) {
    EXPECT_THAT(Definition("command_t"), testing::HasSubstr('"' + std::string(verb) + '"'));
  }
}

TEST(ProcessNames, AreSectionsOfTheConfiguration) {
  const std::string configuration = ReadText(test::SourceFolder() / "config/plslam.yaml");
  for (const char* name : process_name::kAll) {
    EXPECT_THAT(configuration, testing::HasSubstr("\n" + std::string(name) + ":"));
  }
}

}  // namespace
}  // namespace plslam
