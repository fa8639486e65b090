// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/installed_services.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

#include "tests/support/data_folder.h"
#include "tests/support/sanitized.h"
#include "tests/support/text_file.h"

namespace plslam::test {
namespace {

namespace fs = std::filesystem;
using launcher::ChildProcess;

constexpr const char* kEnv = "/usr/bin/env";

std::optional<int> Wait(ChildProcess& process, int limit_s) {
  const auto end = std::chrono::steady_clock::now() + Patience(std::chrono::seconds(limit_s));
  while (!process.Poll() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return process.Poll() ? std::optional(process.Poll()->code) : std::nullopt;
}

/// Writes the units with the script of `cmake --install`, and returns their folder.
fs::path WriteUnits(const fs::path& root) {
  const fs::path prefix = BinaryFolder().parent_path(), scripts = SourceFolder();
  ChildProcess install(kEnv,
                       {"DESTDIR=" + root.string(), CMAKE_PROGRAM, "-DCMAKE_INSTALL_PREFIX=" + prefix.string(),
                        "-DPLSLAM_UNITS=" + (scripts / "scripts" / "systemd").string(), "-P",
                        (scripts / "cmake" / "install_units.cmake").string()},
                       root / "units.log");
  if (Wait(install, 60) != 0) throw std::runtime_error("the units are not written: " + ReadText(root / "units.log"));
  return root / prefix.relative_path() / "share" / "plslam" / "systemd";
}

/// Variables that systemd sets for the service of a user, and options of sanitizers.
std::vector<std::string> EnvironmentOf(const SystemdUnit& unit, const SystemdFolders& folders) {
  std::vector<std::string> environment = {"PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin", "LANG=C.UTF-8",
                                          "USER=plslam", "LOGNAME=plslam", "HOME=/"};
  if (!unit.state_directory.empty())
    environment.push_back("STATE_DIRECTORY=" + (folders.state / unit.state_directory).string());
  if (!unit.runtime_directory.empty())
    environment.push_back("RUNTIME_DIRECTORY=" + (folders.runtime / unit.runtime_directory).string());
  environment.insert(environment.end(), unit.environment.begin(), unit.environment.end());
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (std::string_view(*variable).find("SAN_OPTIONS=") != std::string_view::npos) {
      environment.emplace_back(*variable);
    }
  }
  return environment;
}

}  // namespace

InstalledServices::InstalledServices(fs::path folder, std::string instance, const std::string& configuration)
    : folder_(std::move(folder)),
      instance_(std::move(instance)),
      folders_{folder_ / "etc", folder_ / "var" / "lib", folder_ / "run"} {
  fs::create_directories(folder_ / "journal");
  fs::create_directories(folders_.etc / "plslam");
  std::ofstream(folders_.etc / "plslam" / (instance_ + ".yaml")) << configuration;
  WriteUnits(folder_);
}

InstalledServices::~InstalledServices() {
  processes_.clear();
  ExpectNoSanitizerReports(Logs());
}

SystemdUnit InstalledServices::UnitOf(const std::string& name) const {
  const fs::path units = folder_ / BinaryFolder().parent_path().relative_path() / "share" / "plslam" / "systemd";
  return ReadSystemdUnit(units / fmt::format("plslam-{}@.service", name), instance_, folders_);
}

fs::path InstalledServices::LogFile(const std::string& name, int start) const {
  return folder_ / "journal" / fmt::format("{}@{}.{}.log", name, instance_, start);
}

/// `env` executes the command in its own place, with the same process id.
std::unique_ptr<ChildProcess> InstalledServices::Run(const SystemdUnit& unit, const SystemdUnit::Command& command,
                                                     const fs::path& log) const {
  std::vector<std::string> arguments = {"-i"};
  if (!unit.working_directory.empty()) arguments.push_back("--chdir=" + unit.working_directory);
  for (const std::string& variable : EnvironmentOf(unit, folders_)) arguments.push_back(variable);
  arguments.insert(arguments.end(), command.words.begin(), command.words.end());
  return std::make_unique<ChildProcess>(kEnv, arguments, log, unit.nice);
}

void InstalledServices::Start(const std::string& name) {
  const SystemdUnit unit = UnitOf(name);
  fs::create_directories(folders_.state / unit.state_directory);
  fs::create_directories(folders_.runtime / unit.runtime_directory);
  const fs::path log = LogFile(name, ++starts_[name]);
  for (const SystemdUnit::Command& command : unit.start_pre) {
    const std::unique_ptr<ChildProcess> before = Run(unit, command, log);
    if (Wait(*before, 60) != 0 && !command.may_fail) throw std::runtime_error("ExecStartPre failed: " + Log(name));
  }
  processes_[name] = Run(unit, unit.start, log);
}

void InstalledServices::Signal(const std::string& name, int signal) const { processes_.at(name)->Signal(signal); }

int InstalledServices::ExitCode(const std::string& name, int limit_s) {
  return Wait(*processes_.at(name), limit_s).value_or(-1);
}

bool InstalledServices::Runs(const std::string& name) {
  const auto process = processes_.find(name);
  return process != processes_.end() && !process->second->Poll();
}

fs::path InstalledServices::StateFolder(const std::string& name) const {
  return folders_.state / UnitOf(name).state_directory;
}

std::string InstalledServices::Log(const std::string& name) const {
  const auto start = starts_.find(name);
  return start == starts_.end() ? "" : ReadText(LogFile(name, start->second));
}

std::string InstalledServices::Logs() const {
  std::string text;
  for (const auto& [name, starts] : starts_) {
    for (int start = 1; start <= starts; ++start) {
      text += fmt::format("{} {}:\n{}", name, start, ReadText(LogFile(name, start)));
    }
  }
  return text;
}

}  // namespace plslam::test
