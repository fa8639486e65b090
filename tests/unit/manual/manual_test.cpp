// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/data_folder.h"
#include "tools/manual/completion.h"
#include "tools/manual/help_page.h"
#include "tools/manual/manual_page.h"

namespace plslam::manual {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

/// A program with one option of every sort that CLI11 prints differently.
struct SomeProgram {
  CLI::App app{"Does things.\nAnd others.", "some"};
  std::string file = "a.txt", choice, long_one;
  int bounded = 3;
  bool quiet = false;
  std::vector<std::string> many;
  SomeProgram() {
    app.add_option("input", file, "what is read")->required();
    app.add_option("-o,--out", file, "what is written")->type_name("FILE")->capture_default_str();
    app.add_option("--kind", choice, "which")->check(CLI::IsMember({"one", "two"}));
    app.add_option("--a-name-that-is-very-long-indeed", long_one, "first line\nsecond line");
    app.add_option("--bounded", bounded, "a number")->check(CLI::Range(0, 1000000))->capture_default_str();
    app.add_option("--many", many, "several")->expected(1, 9);
    app.add_option("--folder", file, "where")->type_name("DIR");
    app.add_flag("--quiet", quiet, "print nothing");
    app.set_version_flag("--version", "1");
    app.add_subcommand("go", "starts - quickly");
    app.add_subcommand("stop", "stops");
    app.footer("Examples:\n  some a.txt\n  .some line with a dot and a \\\n`some extra --help` tells more.");
  }
};

TEST(HelpPage, HasEveryOptionOfTheApp) {
  SomeProgram program;
  const HelpPage page = ParseHelp("some", program.app.help());
  EXPECT_EQ(page.purpose, "Does things.\nAnd others.");
  std::vector<std::string> names, expected;
  for (const HelpEntry& entry : page.options) names.insert(names.end(), entry.names.begin(), entry.names.end());
  for (const CLI::Option* option : program.app.get_options()) {
    for (const std::string& name : option->get_snames()) expected.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) expected.push_back("--" + name);
  }
  EXPECT_THAT(names, testing::UnorderedElementsAreArray(expected)) << program.app.help();
  ASSERT_EQ(page.arguments.size(), 1U);
  EXPECT_THAT(page.arguments[0].names, ElementsAre("input"));
  EXPECT_THAT(page.CommandNames(), ElementsAre("go", "stop", "extra"));
  EXPECT_THAT(page.footer, testing::StartsWith("Examples:"));
}

const HelpEntry& Named(const HelpPage& page, const std::string& name) {
  for (const HelpEntry& entry : page.options) {
    if (std::find(entry.names.begin(), entry.names.end(), name) != entry.names.end()) return entry;
  }
  throw std::runtime_error(name + " is missing");
}

TEST(HelpPage, MeaningsAndValues) {
  SomeProgram program;
  const HelpPage page = ParseHelp("some", program.app.help());
  EXPECT_EQ(Named(page, "--a-name-that-is-very-long-indeed").meaning, "first line second line");
  EXPECT_THAT(Named(page, "--kind").choices, ElementsAre("one", "two"));
  EXPECT_EQ(Named(page, "--kind").meaning, "which");
  EXPECT_EQ(Named(page, "--bounded").meaning, "a number");
  EXPECT_FALSE(Named(page, "--quiet").TakesValue());
  EXPECT_THAT(Named(page, "-o").value, HasSubstr("FILE"));
}

TEST(HelpPage, OtherTextIsRefused) {
  for (const char* text : {"", "rubbish", "Usage: x [OPTIONS]\n", "a\nUsage: x [OPTIONS]\n  --no-heading\n",
                           "a\nUsage: x [OPTIONS]\n\nOptions:\n                              nothing above\n"}) {
    EXPECT_THROW(ParseHelp("x", text), std::runtime_error) << text;
  }
}

class Shell : public testing::Test {
 protected:
  Shell() {
    std::string pattern = testing::TempDir() + "manual XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~Shell() override { fs::remove_all(folder_); }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::string Output(const std::string& command) const {
    const std::string path = (folder_ / "output").string();
    EXPECT_EQ(std::system(("{ " + command + "\n} >'" + path + "' 2>&1").c_str()), 0) << command;  // NOLINT
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// Returns bash's completions after `words` (the last one is being typed).
  std::string Completed(const std::string& completion, const std::string& words) const {
    const std::string function =
        completion.substr(completion.find("\n_") + 1, completion.find("()") - completion.find("\n_") - 1);
    const std::string script = completion + "COMP_WORDS=(" + words + ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n" +
                               function + "\nprintf '%s ' \"${COMPREPLY[@]}\"\n";
    return Output("cd '" + folder_.string() + "' && bash '" + Write("script", script) + "'");
  }
  fs::path folder_;
};

TEST_F(Shell, CompletesOptionsCommandsValuesAndFiles) {
  SomeProgram program;
  HelpPage go = ParseHelp("some go", program.app.get_subcommand("go")->help("some"));
  const std::string completion = BashCompletion({ParseHelp("some", program.app.help()), go});
  EXPECT_EQ(Completed(completion, "some --kin"), "--kind ");
  EXPECT_EQ(Completed(completion, "some --kind t"), "two ");
  EXPECT_EQ(Completed(completion, "some g"), "go ");
  EXPECT_EQ(Completed(completion, "some go --k"), " ") << "an option of another command";
  EXPECT_EQ(Completed(completion, "some go --he"), "--help ");
  Write("map.ply", "");
  fs::create_directory(folder_ / "map_folder");
  EXPECT_THAT(Completed(completion, "some --out map"), HasSubstr("map.ply"));
  EXPECT_EQ(Completed(completion, "some --folder map"), "map_folder ");
}

bool Has(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null").c_str()) == 0;  // NOLINT
}

TEST_F(Shell, FishOffersTheSame) {
  if (!Has("fish")) GTEST_SKIP() << "no fish here";
  SomeProgram program;
  HelpPage go = ParseHelp("some go", program.app.get_subcommand("go")->help("some"));
  const std::string path = Write("some.fish", FishCompletion({ParseHelp("some", program.app.help()), go}));
  Write("map.ply", "");
  fs::create_directory(folder_ / "map_folder");
  const auto completed = [&](const std::string& words) {
    return Output("cd '" + folder_.string() + "' && HOME=$PWD fish --no-config -c 'source \"" + path +
                  "\"; complete -C \"" + words + "\"'");
  };
  EXPECT_EQ(completed("some --kin"), "--kind\twhich\n");
  EXPECT_EQ(completed("some --kind t"), "two\twhich\n");
  EXPECT_THAT(completed("some g"), HasSubstr("go\tstarts - quickly\n"));
  EXPECT_THAT(completed("some go --"), testing::AllOf(HasSubstr("--help\t"), testing::Not(HasSubstr("--kind"))));
  EXPECT_THAT(completed("some --out map"), HasSubstr("map.ply"));
  EXPECT_THAT(completed("some --folder map"),
              testing::AllOf(HasSubstr("map_folder/"), testing::Not(HasSubstr("map.ply"))));
}

/// Completion in zsh needs its line editor, which the test drives through a terminal, by the Tab key.
TEST_F(Shell, ZshCompletesTheSame) {
  if (!Has("zsh")) GTEST_SKIP() << "no zsh here";
  SomeProgram program;
  HelpPage go = ParseHelp("some go", program.app.get_subcommand("go")->help("some"));
  Write("_some", ZshCompletion({ParseHelp("some", program.app.help()), go}));
  Write("map.ply", "");
  fs::create_directory(folder_ / "map_folder");
  // Control-X prints the line as it is then, between brackets that the shell's echo of this text does not have.
  const std::string script = Write("drive", R"(zmodload zsh/zpty
zpty shell "zsh -f -i"
zpty -w shell "PS1=; fpath=(\$PWD \$fpath); autoload -U compinit; compinit -u -D"
zpty -w shell "show() { print -r -- '<''<'\$BUFFER'>''>'; BUFFER=; }; zle -N show; bindkey '^X' show"
for words in "$@"; do
  zpty -n -w shell "$words"$'\t\x18'
  zpty -r -m shell out '*<<*>>*'
  print -r -- "${${out##*<<}%%>>*}"
done
)");
  EXPECT_EQ(Output("cd '" + folder_.string() + "' && timeout 60 zsh -f '" + script +
                   "' 'some --kin' 'some --kind t' 'some g' 'some go --he' 'some go --ki' 'some --folder ma'"),
            "some --kind \nsome --kind two \nsome go \nsome go --help \nsome go --ki\nsome --folder map_folder/\n");
}

/// The output of a running program: coloured if a terminal reads it, unless the user has set NO_COLOR.
TEST_F(Shell, ColoursAreForTerminalsAlone) {
  if (!Has("script")) GTEST_SKIP() << "no script here";
  const std::string program = (test::BinaryFolder() / "mapping_process").string() + " --url memq://";
  const auto said = [&](const std::string& start, const std::string& process) {
    // It handles signals only after it has published "ready".
    return Output("cd '" + folder_.string() + "'; rm -f said; unset NO_COLOR; export TERM=xterm\n" + start +
                  " &\nuntil grep -qs 'ready on' said; do sleep 0.05; done; kill " + process + "; wait; cat said");
  };
  const std::string colour = "\033[32minfo";
  const std::string on_terminal = "script -qfc 'exec " + program + "' said";
  EXPECT_THAT(said(on_terminal, "$(pgrep -P $!)"), HasSubstr(colour));
  EXPECT_THAT(said("NO_COLOR=1 " + on_terminal, "$(pgrep -P $!)"),
              testing::AllOf(HasSubstr("info"), testing::Not(HasSubstr(colour))));
  EXPECT_THAT(said("exec " + program + " >said 2>&1", "$!"),
              testing::AllOf(HasSubstr("info"), testing::Not(HasSubstr("\033["))));
}

TEST_F(Shell, TroffTakesThePageWithoutWarning) {
  if (std::system("command -v groff >/dev/null") != 0) GTEST_SKIP() << "no groff here";  // NOLINT
  SomeProgram program;
  HelpPage go = ParseHelp("some go", program.app.get_subcommand("go")->help("some"));
  const std::string path =
      Write("some.1", ManualPage({ParseHelp("some", program.app.help()), go}, "1", {"some", "other"}));
  EXPECT_EQ(Output("groff -man -Tascii -ww -z '" + path + "'"), "");
  const std::string text = Output("groff -man -Tascii -P-cbou '" + path + "'");
  for (const char* part : {"--a-name-that-is-very-long-indeed", ".some line with a dot and a \\", "some go",
                           "EXIT STATUS", "other(1)"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

TEST_F(Shell, HelpShowsDefaults) {
  struct Row {
    std::string command, option, value;
  };
  for (const Row& row : std::vector<Row>{{"evaluate", "--align", "se3"},
                                         {"evaluate", "--max-difference", "0.02"},
                                         {"evaluate", "--delta", "1f 1s 1m"},
                                         {"evaluate places", "--distance", "1"},
                                         {"train_vocabulary", "--stride", "1"},
                                         {"player", "--start", "0"},
                                         {"viewer_headless", "--out", "out"},
                                         {"pose_graph", "--perturb", "0"},
                                         {"plslam run", "--max-restarts", "5"},
                                         {"plslam run", "--overlay-every", "0"}}) {
    const std::string help = Output((test::BinaryFolder() / row.command).string() + " --help");
    EXPECT_THAT(help, testing::ContainsRegex("  " + row.option + " [^\n]*=" + row.value)) << row.command;
  }
}

/// As built, of the real programs.
TEST_F(Shell, EveryProgramHasAManualAndCompletion) {
  const fs::path share = test::BinaryFolder().parent_path() / "share";
  for (const char* program : {"plslam", "adapter", "player", "vo_process", "mapping_process", "loop_process",
                              "viewer_headless", "evaluate", "train_vocabulary", "pose_graph"}) {
    const fs::path page = share / "man" / "man1" / (std::string(program) + ".1.gz");
    const fs::path completion = share / "bash-completion" / "completions" / program;
    ASSERT_TRUE(fs::exists(page)) << page;
    ASSERT_TRUE(fs::exists(completion)) << completion;
    EXPECT_EQ(Output("bash -n '" + completion.string() + "'"), "");
    const fs::path zsh = share / "zsh/vendor-completions" / (std::string("_") + program);
    const fs::path fish = share / "fish/vendor_completions.d" / (std::string(program) + ".fish");
    ASSERT_TRUE(fs::exists(zsh) && fs::exists(fish));
    if (Has("zsh")) {
      EXPECT_EQ(Output("zsh -n '" + zsh.string() + "'"), "");
    }
    if (Has("fish")) {
      EXPECT_EQ(Output("fish -n '" + fish.string() + "'"), "");
    }
    if (std::system("command -v groff >/dev/null") == 0) {  // NOLINT
      EXPECT_EQ(Output("zcat '" + page.string() + "' | groff -man -Tutf8 -Kutf8 -ww -z"), "") << program;
    }
  }
}

}  // namespace
}  // namespace plslam::manual
