// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/bus/bus_fixture.h"

#include <cstdlib>
#include <filesystem>
#include <random>

namespace plslam::bus::test {

std::string PrivateUrl() {
  static std::random_device device;
  const auto part = [&](unsigned from, unsigned n) { return std::to_string(from + device() % n); };
  // Ports below those that the system gives to sockets without a port (from 32,768 on): such a socket is exclusive.
  return "udpm://239.255." + part(100, 100) + "." + part(1, 250) + ":" + part(20000, 12000) + "?ttl=0";
}

int Shell(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool HasProgram(const std::string& name) { return Shell("command -v " + name + " > /dev/null 2>&1") == 0; }

TemporaryFolder::TemporaryFolder() {
  std::string pattern = std::filesystem::temp_directory_path() / "plslam-test-XXXXXX";
  path_ = mkdtemp(pattern.data());
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

bool WaitForReaders(Bus& publisher, const Channel& channel, int n) {
  // Readers are known only after the first use of the channel.
  return Eventually([&] { return publisher.ReaderCount(channel) >= n; });
}

}  // namespace plslam::bus::test
