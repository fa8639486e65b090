// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <iostream>

#include "tests/support/data_folder.h"
#include "tests/unit/structure/configuration_reference.h"

/// Generates docs/configuration.md and config/plslam.yaml.
int main() {
  using namespace plslam::test;  // NOLINT(google-build-using-namespace)
  const auto write = [](const std::string& path, const std::string& text) {
    std::ofstream file(SourceFolder() / path);
    file << text;
    std::cout << path << "\n";
    return file.good();
  };
  const bool written = write("docs/configuration.md", ConfigurationReference());
  return write("config/plslam.yaml", ConfigurationFile()) && written ? 0 : 1;
}
