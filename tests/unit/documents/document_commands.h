// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plslam::test {

/// A command in a document for its reader.
struct DocumentCommand {
  std::string text;  ///< without comment, continued lines joined
  int line = 0;      ///< in the document
};

/// The commands of one fenced block marked `sh`.
using CommandBlock = std::vector<DocumentCommand>;

std::vector<CommandBlock> CommandBlocks(const std::string& markdown);

/// README.md and docs/*.md.
std::vector<std::filesystem::path> DocumentsWithCommands();

/// Returns the reason why the test does not run `command`; empty if it does.
std::string WhyNotRun(const std::string& command);

/// Patterns of that table which no command of any document matches.
std::vector<std::string> IdleRows();

/// Returns whether it runs until it is interrupted, as a player does if no vo_process of its block answers it.
bool IsEndless(const std::string& command, bool block_has_vo);

/// Returns the command with a tiny world for each dataset, on a separate bus.
std::string WithStandIns(const std::string& command, bool block_has_vo, int port);

}  // namespace plslam::test
