// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/unit/documents/document_commands.h"
#include "tools/launch/child_process.h"
#include "tools/launch/run_bus.h"

namespace plslam::test {

/// A folder in which a reader of the documents might sit: `build/release/bin`, `config`, and the files that documents
/// take for granted (`my_camera`, `my.plmap`, ...), made when a command names them.
class DocumentWorld {
 public:
  DocumentWorld();
  ~DocumentWorld();
  DocumentWorld(const DocumentWorld&) = delete;
  DocumentWorld& operator=(const DocumentWorld&) = delete;

  /// Runs a block, and interrupts its endless commands when the rest is done. Returns the failures, with the output of
  /// the command; empty if all ended with exit code 0.
  std::string Run(const CommandBlock& block);

 private:
  struct Running {
    DocumentCommand command;
    std::filesystem::path log;
    std::unique_ptr<launcher::ChildProcess> process;
  };

  void MakeFilesFor(const std::string& command);
  Running Start(const DocumentCommand& command, bool block_has_vo);
  std::string Finish(Running& running) const;

  launcher::PrivatePort port_;
  std::filesystem::path folder_;
  std::string environment_;
  int started_ = 0;
};

}  // namespace plslam::test
