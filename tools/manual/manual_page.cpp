// SPDX-License-Identifier: BSD-3-Clause
#include "tools/manual/manual_page.h"

#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace plslam::manual {
namespace {

/// Text as troff prints it: backslashes and hyphens as they are, no line taken for a request.
std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out.starts_with('.') || out.starts_with('\'') ? fmt::format("\\&{}", out) : out;
}

std::string Upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

void AppendEntries(const std::vector<HelpEntry>& entries, std::string* out) {
  for (const HelpEntry& entry : entries) {
    *out += fmt::format(".TP\n\\fB{}\\fR", Escaped(fmt::format("{}", fmt::join(entry.names, ", "))));
    if (entry.TakesValue()) *out += fmt::format(" \\fI{}\\fR", Escaped(entry.value));
    *out += fmt::format("\n{}\n", entry.meaning.empty() ? "\\&" : Escaped(entry.meaning));
  }
}

/// Lines as they are: examples, mostly.
void AppendVerbatim(const std::string& text, std::string* out) {
  *out += ".PP\n.nf\n";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    *out += fmt::format("{}\n", line.empty() ? "\\&" : Escaped(line));
  *out += ".fi\n";
}

void AppendSynopsis(const HelpPage& page, std::string* out) {
  *out += fmt::format(".PP\n\\fB{}\\fR {}\n", Escaped(page.command), Escaped(page.usage));
}

void AppendCommand(const HelpPage& page, std::string* out) {
  *out += fmt::format(".SS {}\n{}\n", Escaped(page.command), Escaped(page.purpose));
  AppendSynopsis(page, out);
  AppendEntries(page.arguments, out);
  AppendEntries(page.options, out);
  if (!page.footer.empty()) AppendVerbatim(page.footer, out);
}

constexpr char kExitStatus[] =
    ".SH EXIT STATUS\n"
    ".TP\n\\fB0\\fR\nDone, or ended by SIGINT, SIGTERM or SIGHUP.\n"
    ".TP\n\\fB1\\fR\nFailed. One sentence on standard error gives the reason and names the file, line, key or "
    "value.\n";

}  // namespace

std::string ManualPage(const std::vector<HelpPage>& pages, const std::string& version,
                       const std::vector<std::string>& programs) {
  const HelpPage& own = pages[0];
  std::string out =
      fmt::format(".TH {} 1 \"\" \"plslam {}\" \"plslam\"\n", Escaped(Upper(own.command)), Escaped(version));
  out += fmt::format(".SH NAME\n{} \\- {}\n", Escaped(own.command), Escaped(own.purpose));
  out += ".SH SYNOPSIS\n";
  for (const HelpPage& page : pages) AppendSynopsis(page, &out);
  out += ".SH OPTIONS\n";
  AppendEntries(own.arguments, &out);
  AppendEntries(own.options, &out);
  if (pages.size() > 1) out += ".SH COMMANDS\n";
  for (size_t i = 1; i < pages.size(); ++i) AppendCommand(pages[i], &out);
  if (!own.footer.empty()) {
    out += ".SH NOTES\n";
    AppendVerbatim(own.footer, &out);
  }
  out += kExitStatus;
  out += ".SH SEE ALSO\n";
  std::string others;
  for (const std::string& program : programs) {
    if (program != own.command)
      others += fmt::format("{}\\fB{}\\fR(1)", others.empty() ? "" : ", ", Escaped(program));
  }
  return out + others + "\n";
}

}  // namespace plslam::manual
