// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plslam::test {

/// A command that a document tells its reader to run.
struct DocumentCommand {
  std::string text;  ///< without comment, continued lines joined
  int line = 0;      ///< in the document
};

/// The commands of one fenced block marked `sh`.
using CommandBlock = std::vector<DocumentCommand>;

std::vector<CommandBlock> CommandBlocks(const std::string& markdown);

/// README.md and docs/*.md.
std::vector<std::filesystem::path> DocumentsWithCommands();

/// Why the test does not run `command`; empty where it does.
std::string WhyNotRun(const std::string& command);

/// Patterns of that table which no command of any document matches.
std::vector<std::string> IdleRows();

/// Whether it runs until it is interrupted; a player does where no vo_process of its block answers it.
bool IsEndless(const std::string& command, bool block_has_vo);

/// The command with a tiny world for each dataset, on a bus of its own.
std::string WithStandIns(const std::string& command, bool block_has_vo, int port);

}  // namespace plslam::test
