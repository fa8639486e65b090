// SPDX-License-Identifier: BSD-3-Clause
// plslam_manual FOLDER VERSION PROGRAM...: runs each program with --help, and each of its commands, and writes
// FOLDER/man/man1/NAME.1.gz and its completion for bash, zsh and fish where Debian's shells look for it.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

#include "tools/manual/completion.h"
#include "tools/manual/help_page.h"
#include "tools/manual/manual_page.h"

namespace plslam::manual {
namespace {

namespace fs = std::filesystem;

std::string HelpOf(const fs::path& program, const std::string& command) {
  const std::string line = fmt::format("'{}' {} --help", program.string(), command);
  FILE* pipe = popen(line.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error(line + " cannot be run");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  if (pclose(pipe) != 0) throw std::runtime_error(line + " fails");
  return text;
}

std::vector<HelpPage> PagesOf(const fs::path& program) {
  const std::string name = program.filename();
  std::vector<HelpPage> pages{ParseHelp(name, HelpOf(program, ""))};
  for (const std::string& command : pages[0].CommandNames()) {
    pages.push_back(ParseHelp(fmt::format("{} {}", name, command), HelpOf(program, command)));
  }
  return pages;
}

void Write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream file(path);
  if (!(file << text).flush()) throw std::runtime_error(path.string() + " cannot be written");
}

/// Compressed as required by Debian for manual pages.
void WriteCompressed(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  gzFile file = gzopen(path.c_str(), "wb9");
  const auto size = static_cast<int>(text.size());
  const bool is_written = file != nullptr && gzwrite(file, text.data(), static_cast<unsigned>(size)) == size;
  if (gzclose(file) != Z_OK || !is_written) throw std::runtime_error(path.string() + " cannot be written");
}

void WriteAll(const fs::path& folder, const std::string& version, const std::vector<fs::path>& programs) {
  std::vector<std::string> names;
  names.reserve(programs.size());
  for (const fs::path& program : programs) names.push_back(program.filename());
  for (const fs::path& program : programs) {
    const std::vector<HelpPage> pages = PagesOf(program);
    const std::string name = program.filename();
    WriteCompressed(folder / "man" / "man1" / (name + ".1.gz"), ManualPage(pages, version, names));
    Write(folder / "bash-completion" / "completions" / name, BashCompletion(pages));
    Write(folder / "zsh" / "vendor-completions" / ("_" + name), ZshCompletion(pages));
    Write(folder / "fish" / "vendor_completions.d" / (name + ".fish"), FishCompletion(pages));
  }
}

}  // namespace
}  // namespace plslam::manual

int main(int argc, char** argv) {
  try {
    if (argc < 4) throw std::runtime_error("three arguments are needed: FOLDER VERSION PROGRAM...");
    plslam::manual::WriteAll(argv[1], argv[2], {argv + 3, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    std::fputs(fmt::format("plslam_manual: error: {}\n", error.what()).c_str(), stderr);
    return 1;
  }
}
