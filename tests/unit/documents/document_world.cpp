// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/documents/document_world.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <regex>
#include <thread>

#include "core/datasets/open_dataset.h"
#include "tests/integration/image_folder_of.h"
#include "tests/support/data_folder.h"

namespace plslam::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kLimit(60);

std::string ReadAll(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool PollUntil(const std::function<bool()>& done) {
  const auto end = Clock::now() + kLimit;
  while (!done() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return done();
}

/// Returns whether the program handles SIGINT, so that an interruption is an orderly end.
bool MindsInterrupts(pid_t pid) {
  const std::string status = ReadAll(fmt::format("/proc/{}/status", pid));
  uint64_t signals = 0;
  for (const char* key : {"SigBlk:\t", "SigCgt:\t"}) {
    const size_t at = status.find(key);
    if (at != std::string::npos) signals |= std::stoull(status.substr(at + 8, 16), nullptr, 16);
  }
  return (signals & (uint64_t{1} << (SIGINT - 1))) != 0;
}

/// Two closed squares of poses, in files with the names of public graphs.
void WriteSmallGraph(const fs::path& path) {
  std::ofstream file(path);
  for (int i = 0; i < 8; ++i)
    file << "VERTEX_SE2 " << i << " " << i % 4 / 2 << " " << (i + 1) % 4 / 2 << " " << 1.57 * i << "\n";
  for (int i = 0; i < 8; ++i) file << "EDGE_SE2 " << i << " " << (i + 1) % 8 << " 1 0 1.5707963 100 0 0 100 0 100\n";
}

void WriteCamera(const fs::path& folder) {
  const auto dataset = OpenDataset("synthetic:room?frames=6&size=376x240", "");
  std::vector<ChosenFrame> frames;
  for (int i = 0; i < dataset->size(); ++i) frames.push_back({i, false});
  WriteImageFolder(*dataset, frames, folder);
}

}  // namespace

DocumentWorld::DocumentWorld() {
  std::string pattern = testing::TempDir() + "documents-XXXXXX";
  folder_ = mkdtemp(pattern.data());
  fs::create_directories(folder_ / "build" / "release");
  fs::create_directory_symlink(BinaryFolder(), folder_ / "build" / "release" / "bin");
  fs::create_directory_symlink(SourceFolder() / "config", folder_ / "config");
  fs::create_directory(folder_ / "out");
  environment_ = fmt::format("export PATH='{}':\"$PATH\" LCM_DEFAULT_URL='{}' HOME='{}'\ncd '{}'\n",
                             BinaryFolder().string(), port_.Url(), folder_.string(), folder_.string());
}

DocumentWorld::~DocumentWorld() { fs::remove_all(folder_); }

void DocumentWorld::MakeFilesFor(const std::string& command) {
  static const std::regex kFile(R"((^| )([\w./]+\.(plmap|g2o)|my_camera)\b)");
  // Files that a command writes need not exist.
  for (std::sregex_iterator it(command.begin(), command.end(), kFile), end; it != end; ++it) {
    const fs::path path = folder_ / (*it)[2].str();
    if (fs::exists(path)) continue;
    const bool written = std::regex_search((*it).prefix().str(), std::regex("(--save-map|--out|--tum)$"));
    if (written) continue;
    fs::create_directories(path.parent_path());
    if (path.filename() == "my_camera") WriteCamera(path);
    if (path.extension() == ".g2o") WriteSmallGraph(path);
    if (path.extension() == ".plmap") {
      DocumentCommand make{
          fmt::format("plslam run 'synthetic:room?frames=6&size=376x240' --quiet --out made --save-map {}",
                      path.string()),
          0};
      Running run = Start(make, false);
      EXPECT_EQ(Finish(run), "");
    }
  }
}

DocumentWorld::Running DocumentWorld::Start(const DocumentCommand& command, bool block_has_vo) {
  const std::string script = (folder_ / fmt::format("command{}.sh", started_)).string();
  const fs::path log = folder_ / fmt::format("command{}.log", started_);
  ++started_;
  const std::string text = WithStandIns(command.text, block_has_vo, port_.port());
  // With exec, so that an interruption reaches the program; not where the shell has more to do than to start one.
  const bool simple = text.find_first_of("|&;<>") == std::string::npos || text.find('\'') != std::string::npos;
  std::ofstream(script) << environment_ << (simple ? "exec " : "set -e\n") << text << "\n";
  return {command, log, std::make_unique<launcher::ChildProcess>("/bin/bash", std::vector<std::string>{script}, log)};
}

std::string DocumentWorld::Finish(Running& running) const {
  const bool ended = PollUntil([&] { return running.process->Poll().has_value(); });
  if (!ended) running.process->Signal(SIGKILL);
  if (ended && running.process->Poll()->code == 0) return "";
  return fmt::format("line {}: {}\n{}:\n{}\n", running.command.line, running.command.text,
                     ended ? fmt::format("ended with {}", running.process->Poll()->code) : "has not ended",
                     ReadAll(running.log));
}

std::string DocumentWorld::Run(const CommandBlock& block) {
  const bool has_vo = std::any_of(block.begin(), block.end(), [](const DocumentCommand& c) {
    return c.text.find("vo_process") != std::string::npos;
  });
  std::string problems;
  std::vector<Running> endless;
  for (const DocumentCommand& command : block) {
    if (!WhyNotRun(command.text).empty()) continue;
    if (command.text.starts_with("export ")) {
      environment_ += WithStandIns(command.text, has_vo, port_.port()) + "\n";
      continue;
    }
    MakeFilesFor(command.text);
    Running running = Start(command, has_vo);
    if (IsEndless(command.text, has_vo)) {
      endless.push_back(std::move(running));
    } else {
      problems += Finish(running);
    }
  }
  for (Running& running : endless) {
    PollUntil([&] { return running.process->Poll().has_value() || MindsInterrupts(running.process->pid()); });
    running.process->Signal(SIGINT);
  }
  for (Running& running : endless) problems += Finish(running);
  return problems;
}

}  // namespace plslam::test
