// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/whole_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "tests/support/data_folder.h"
#include "tests/support/sanitized.h"
#include "tests/support/text_file.h"

namespace plslam::test {
namespace {

using Clock = std::chrono::steady_clock;

bool PollUntil(const std::function<bool()>& done, std::chrono::seconds limit) {
  const auto end = Clock::now() + Patience(limit);
  while (!done() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return done();
}

}  // namespace

WholeRun::WholeRun() {
  std::string pattern = testing::TempDir() + "whole run XXXXXX";
  folder_ = mkdtemp(pattern.data());
}

WholeRun::~WholeRun() {
  const std::vector<pid_t> pids = process_ && !ended() ? Pids() : std::vector<pid_t>{};
  process_.reset();
  // Without their launcher they still write their files, into the folder to be removed.
  EXPECT_TRUE(WaitFor([&] { return Ended(pids); }));
  ExpectNoSanitizerReports(Logs());
  if (std::getenv("PLSLAM_KEEP_RUNS") != nullptr) return;
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
  EXPECT_FALSE(error) << folder_ << ": " << error.message();
}

void WholeRun::Start(std::vector<std::string> arguments) {
  if (arguments[0] != "relay") arguments.insert(arguments.end(), {"--out", out().string()});
  process_ = std::make_unique<launcher::ChildProcess>(BinaryFolder() / "plslam", arguments, folder_ / "plslam.log");
}

int WholeRun::Wait(int limit_s) {
  if (!PollUntil([&] { return process_->Poll().has_value(); }, std::chrono::seconds(limit_s))) {
    process_->Signal(SIGKILL);
    return -1;
  }
  return process_->Poll()->code;
}

int WholeRun::Run(std::vector<std::string> arguments) {
  Start(std::move(arguments));
  return Wait();
}

bool WholeRun::WaitFor(const std::function<bool()>& done) { return PollUntil(done, std::chrono::seconds(60)); }

nlohmann::json WholeRun::Summary() const { return nlohmann::json::parse(Read("summary.json"), nullptr, false); }

std::string WholeRun::Read(const std::string& file_of_out) const { return ReadText(out() / file_of_out); }

std::string WholeRun::Logs() const {
  std::string text = "plslam:\n" + ReadText(folder_ / "plslam.log");
  if (!std::filesystem::exists(out() / "logs")) return text;
  for (const auto& entry : std::filesystem::directory_iterator(out() / "logs")) {
    text += entry.path().filename().string() + ":\n" + ReadText(entry.path());
  }
  return text;
}

pid_t WholeRun::PidOf(const std::string& executable) const {
  for (const pid_t pid : Pids()) {
    if (pid == process_->pid()) continue;
    std::error_code gone;
    const auto exe = std::filesystem::read_symlink("/proc/" + std::to_string(pid) + "/exe", gone);
    if (exe.filename() == executable) return pid;
  }
  return -1;
}

bool WholeRun::Signal(const std::string& executable, int signal) const {
  const pid_t pid = PidOf(executable);
  return pid > 0 && kill(pid, signal) == 0;
}

std::vector<pid_t> WholeRun::Pids() const {
  std::vector<pid_t> pids = {process_->pid()};
  const std::string parent = "\nPPid:\t" + std::to_string(process_->pid()) + "\n";
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::istringstream name(entry.path().filename().string());
    pid_t pid = 0;
    if (!(name >> pid)) continue;
    if (ReadText(entry.path() / "status").find(parent) != std::string::npos) pids.push_back(pid);
  }
  return pids;
}

bool WholeRun::Ended(const std::vector<pid_t>& pids) {
  return std::ranges::none_of(pids, [](pid_t pid) {
    std::error_code ended;
    return std::filesystem::exists("/proc/" + std::to_string(pid) + "/exe", ended);
  });
}

std::optional<int> OnASmallDisk(const std::filesystem::path& folder, int kib, const std::string& command) {
  std::filesystem::create_directories(folder);
  const std::string mount = fmt::format("mount -t tmpfs -o size={}k none '{}'", kib, folder.string());
  const auto with = [&](const std::string& line) {
    // The mount is in a separate namespace: invisible to other processes, and removed with its last process.
    const std::string quoted = fmt::format("unshare --mount --map-root-user sh -c \"{} && {}\" >> '{}.sh.log' 2>&1",
                                           mount, line, folder.string());
    const int status = std::system(quoted.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  if (with("true") != 0) return std::nullopt;
  return with(command);
}

}  // namespace plslam::test
