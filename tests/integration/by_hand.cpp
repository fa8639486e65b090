// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/by_hand.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>

#include "core/process/process_status.h"
#include "plslam/pose_t.hpp"
#include "tests/support/data_folder.h"
#include "tests/support/sanitized.h"
#include "tests/support/text_file.h"

namespace plslam::test {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

ByHand::ByHand(std::string url) : url_(std::move(url)) {
  std::string pattern = testing::TempDir() + "by hand XXXXXX";
  folder_ = mkdtemp(pattern.data());
  std::filesystem::create_directories(out());
}

ByHand::~ByHand() {
  processes_.clear();
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    if (entry.path().extension() == ".log") ExpectNoSanitizerReports(ReadText(entry.path()));
  }
  std::filesystem::remove_all(folder_);
}

void ByHand::Start(const NetworkHost& host, const std::string& executable, std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--url", url_});
  arguments.insert(arguments.end(), common_.begin(), common_.end());
  host.Do([&] { StartPlain(executable, arguments); });
}

void ByHand::StartPlain(const std::string& executable, const std::vector<std::string>& arguments) {
  processes_[executable] = std::make_unique<launcher::ChildProcess>(BinaryFolder() / executable, arguments,
                                                                    folder_ / (executable + ".log"));
}

void ByHand::StartAll(const HostsOfARun& hosts, StatusListener* listener) {
  std::vector<std::string> started;
  const auto start = [&](const NetworkHost* host, const char* process, const char* executable,
                         const std::vector<std::string>& arguments) {
    if (host == nullptr) return;
    Start(*host, executable, arguments);
    started.emplace_back(process);
  };
  start(hosts.recorder, "recorder", "plslam", {"record", log()});
  start(hosts.viewer, "viewer", "viewer_headless", {"--set", "viewer.out=" + out().string()});
  start(hosts.mapping, "mapping", "mapping_process", {});
  start(hosts.loop, "loop", "loop_process", {});
  start(hosts.vo, "vo", "vo_process", {});
  for (const std::string& process : started) {
    ASSERT_TRUE(listener->WaitForState(process, "ready")) << process << " cannot be heard\n" << Logs();
  }
}

void ByHand::StartPlayer(const NetworkHost& host, const std::string& dataset) {
  Start(host, "player", {dataset, "--set", "player.exit=true"});
}

void ByHand::WaitUntilPlayed(StatusListener* listener) {
  ASSERT_EQ(Wait("player"), 0) << Logs();
  ASSERT_TRUE(listener->WaitForState("viewer", "finished")) << Logs();
}

int ByHand::Wait(const std::string& executable, int limit_s) {
  launcher::ChildProcess& process = *processes_.at(executable);
  const auto end = Clock::now() + Patience(std::chrono::seconds(limit_s));
  while (!process.Poll() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (!process.Poll()) process.Signal(SIGKILL);
  return process.Poll() ? process.Poll()->code : -1;
}

void ByHand::Kill(const std::string& executable) {
  processes_.at(executable)->Signal(SIGKILL);
  Wait(executable);
}

bool ByHand::StopAll() {
  for (const auto& [name, process] : processes_) {
    if (!process->Poll()) process->Signal(SIGINT);
  }
  bool all = true;
  for (const auto& [name, process] : processes_) all = Wait(name, 20) == 0 && all;
  return all;
}

std::string ByHand::Read(const std::string& file_of_out) const { return ReadText(out() / file_of_out); }

std::string ByHand::Logs() const {
  std::string text;
  for (const auto& [name, process] : processes_) text += name + ":\n" + ReadText(folder_ / (name + ".log"));
  return text;
}

StatusListener::StatusListener(const NetworkHost& host, const bus::BusOptions& options) {
  host.Do([&] { bus_ = std::make_unique<bus::Bus>(options, "listener"); });
  bus_->Subscribe<status_t>(bus::kStatus, [this](const status_t& status) {
    const std::scoped_lock lock(mutex_);
    statuses_[status.process] = status;
    double& peak = peak_mb_[status.process];
    peak = std::max(peak, status.memory_mb);
    changed_.notify_all();
  });
  bus_->SubscribeBestEffort<pose_t>(bus::kPose, [this](const pose_t& pose) {
    const std::scoped_lock lock(mutex_);
    newest_frame_ = std::max(newest_frame_, pose.frame_id);
    changed_.notify_all();
  });
  thread_ = std::thread([this] { bus_->Run(); });
}

StatusListener::~StatusListener() {
  bus_->Stop();
  thread_.join();
}

bool StatusListener::WaitFor(const std::function<bool(const Statuses&, int64_t)>& done, int limit_s) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, Patience(std::chrono::seconds(limit_s)),
                           [&] { return done(statuses_, newest_frame_); });
}

bool StatusListener::WaitForState(const std::string& process, const std::string& state, int limit_s) {
  return WaitFor(
      [&](const Statuses& statuses, int64_t) {
        const auto found = statuses.find(process);
        return found != statuses.end() && found->second.state == state;
      },
      limit_s);
}

bool StatusListener::WaitForFrame(int64_t frame_id, int limit_s) {
  return WaitFor([&](const Statuses&, int64_t newest) { return newest >= frame_id; }, limit_s);
}

StatusListener::Statuses StatusListener::statuses() const {
  const std::scoped_lock lock(mutex_);
  return statuses_;
}

double StatusListener::Counter(const std::string& process, const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  const auto found = statuses_.find(process);
  return found == statuses_.end() ? 0.0 : bus::CounterOf(found->second, name);
}

double StatusListener::PeakMemory_mb(const std::string& process) const {
  const std::scoped_lock lock(mutex_);
  const auto found = peak_mb_.find(process);
  return found == peak_mb_.end() ? 0.0 : found->second;
}

std::string StatusListener::Reason(const std::string& process) const {
  const std::scoped_lock lock(mutex_);
  const auto found = statuses_.find(process);
  return found == statuses_.end() ? "" : found->second.reason;
}

}  // namespace plslam::test
