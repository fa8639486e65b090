// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/documents/document_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <regex>
#include <sstream>

#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam::test {
namespace {

namespace fs = std::filesystem;

/// Commands that cannot or need not be run here, with the reason.
struct NotRun {
  const char* pattern;  ///< from the begin of the command
  const char* why;
};

constexpr std::array kNotRun = {
    NotRun{"scripts/(demo|setup)", "installs packages and builds"},
    NotRun{"scripts/(test|build|lint|format|benchmark|soak)", "builds or tests the whole tree"},
    NotRun{"scripts/pose_graphs", "rewrites a document, from graphs that are not in the tree"},
    NotRun{"ctest|cmake|cpack", "builds or tests the whole tree; tests/package installs and packs it"},
    NotRun{"sudo|apt|systemctl|journalctl", "changes the machine"},
    NotRun{"lcm-logger|lcm-logplayer", "LCM's own programs, which tests/unit/bus runs with logs of ours"},
    NotRun{"lcm-spy|java", "needs a display; tests/package asks its classes to decode our messages"},
    NotRun{"colmap", "takes minutes; tests/integration has COLMAP read the model"},
    NotRun{"plslam run '?recording", "a recording of ROS: tests/integration/recording_input_test.cpp plays some"},
    NotRun{"plslam calibrate pictures", "pictures of a board: tests/unit/calibration renders some"},
    NotRun{"plslam (calibrate rig.yaml|rectify-check camera_pictures|run camera.yaml)",
           "a camera: tests/integration/calibrate_run_test.cpp has a fake one"},
    NotRun{"plslam (top|pause|resume|localise|save|load|reset)",
           "orders to a run: tests/integration/orders_test.cpp gives them"},
    NotRun{"plslam_ros2|plslam (topics|run) ros2:|ros2 service",
           "a robot: tests/integration/ros2_run_test.cpp drives one"},
    NotRun{"plslam bridge", "a viewer: tests/integration/bridge_run_test.cpp is one"},
    NotRun{"adapter", "a robot: tests/integration/adapter_test.cpp drives one"},
    NotRun{".*(--prefix team/|--map-prefix)", "several robots: tests/integration/fleet_test.cpp runs them"},
};

/// A comment begins after a blank, outside of quotes.
std::string WithoutComment(const std::string& line) {
  char quote = 0;
  for (size_t i = 0; i < line.size(); ++i) {
    if (quote != 0) {
      quote = line[i] == quote ? 0 : quote;
    } else if (line[i] == '\'' || line[i] == '"') {
      quote = line[i];
    } else if (line[i] == '#' && (i == 0 || line[i - 1] == ' ')) {
      return line.substr(0, i);
    }
  }
  return line;
}

std::string Trim(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

bool BeginsWith(const std::string& command, const std::string& pattern) {
  return std::regex_search(command, std::regex(fmt::format("^(build/release/bin/)?({})", pattern)));
}

/// Of all documents.
std::vector<std::string> AllCommands() {
  std::vector<std::string> commands;
  for (const fs::path& document : DocumentsWithCommands()) {
    for (const CommandBlock& block : CommandBlocks(ReadText(document))) {
      for (const DocumentCommand& command : block) commands.push_back(command.text);
    }
  }
  return commands;
}

}  // namespace

std::vector<CommandBlock> CommandBlocks(const std::string& markdown) {
  std::vector<CommandBlock> blocks;
  std::istringstream lines(markdown);
  bool inside = false;
  DocumentCommand command;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with("```")) {
      inside = !inside && line == "```sh";
      if (inside) blocks.emplace_back();
      continue;
    }
    if (!inside) continue;
    std::string text = Trim(WithoutComment(line));
    if (command.text.empty()) command.line = number;
    const bool continues = text.ends_with('\\');
    if (continues) text.pop_back();
    command.text += fmt::format("{}{}", command.text.empty() ? "" : " ", Trim(text));
    if (continues || command.text.empty()) continue;
    blocks.back().push_back(std::move(command));
    command = {};
  }
  std::erase_if(blocks, [](const CommandBlock& block) { return block.empty(); });
  return blocks;
}

std::vector<fs::path> DocumentsWithCommands() {
  std::vector<fs::path> documents;
  for (const auto& entry : fs::directory_iterator(SourceFolder() / "docs")) {
    if (entry.path().extension() == ".md") documents.push_back(entry.path());
  }
  documents.push_back(SourceFolder() / "README.md");
  std::erase_if(documents, [](const fs::path& path) { return CommandBlocks(ReadText(path)).empty(); });
  std::sort(documents.begin(), documents.end());
  return documents;
}

std::string WhyNotRun(const std::string& command) {
  for (const NotRun& row : kNotRun) {
    if (BeginsWith(command, row.pattern)) return row.why;
  }
  return "";
}

std::vector<std::string> IdleRows() {
  const std::vector<std::string> commands = AllCommands();
  std::vector<std::string> idle;
  for (const NotRun& row : kNotRun) {
    const auto fits = [&](const std::string& command) { return BeginsWith(command, row.pattern); };
    if (std::none_of(commands.begin(), commands.end(), fits)) idle.emplace_back(row.pattern);
  }
  return idle;
}

bool IsEndless(const std::string& command, bool block_has_vo) {
  return BeginsWith(command, "viewer_headless|vo_process|mapping_process|loop_process|plslam (relay|record)") ||
         (!block_has_vo && BeginsWith(command, "player"));
}

std::string WithStandIns(const std::string& command, bool block_has_vo, int port) {
  static constexpr char kWorld[] = "'synthetic:room?frames=6&size=376x240'";
  std::string text = command;
  const auto replace = [&](const char* pattern, const std::string& by) {
    text = std::regex_replace(text, std::regex(pattern), by);
  };
  // Datasets of the reader, and whole worlds.
  replace(R"((^| )(/data|~)/[^ ]+)", fmt::format("$1{}", kWorld));
  replace(R"(["']?synthetic:(\w+)(\?[^"' ]*)?["']?)", "'synthetic:$1?frames=6&size=376x240'");
  replace(R"(--start \d+)", "--start 2");
  replace(R"(--stop \d+)", "--stop 5");
  replace(R"(--frame \d+)", "--frame 2");
  // The bus of this test, and no other machine.
  replace(R"(udpm://239\.255\.76\.67:7667\?ttl=\d)", fmt::format("udpm://239.255.76.67:{}?ttl=0", port));
  replace(R"(tcpq://[^ :]+:\d+)", fmt::format("udpm://239.255.76.67:{}?ttl=0", port));
  if (text.ends_with('&')) text = Trim(text.substr(0, text.size() - 1));
  if (block_has_vo && BeginsWith(text, "player") && text.find("--exit") == std::string::npos) text += " --exit";
  if (BeginsWith(text, "plslam relay"))
    text = fmt::format("{} --port 0", std::regex_replace(text, std::regex(R"(--port \d+)"), ""));
  return text;
}

}  // namespace plslam::test
