// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/finding.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

namespace plslam::doctor {

const char* VerdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "good";
    case Verdict::kAdvice:
      return "advice";
    case Verdict::kProblem:
      break;
  }
  return "problem";
}

Finding Good(const std::string& check, const std::string& what) { return {check, Verdict::kGood, what, ""}; }

Finding Advice(const std::string& check, const std::string& what, const std::string& mend) {
  return {check, Verdict::kAdvice, what, mend};
}

Finding Problem(const std::string& check, const std::string& what, const std::string& mend) {
  return {check, Verdict::kProblem, what, mend};
}

std::string AsRoot(const std::string& command) { return geteuid() == 0 ? command : "sudo " + command; }

bool HasProblem(const Findings& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& f) { return f.verdict == Verdict::kProblem; });
}

std::string FindingsToText(const Findings& findings, bool only_bad) {
  std::string text;
  for (const Finding& f : findings) {
    if (only_bad && f.verdict == Verdict::kGood) continue;
    // A problem that prevents operation must stand out.
    const char* verdict = f.verdict == Verdict::kProblem ? "PROBLEM" : VerdictName(f.verdict);
    text += fmt::format("{:<11} {:<8} {}\n", f.check, verdict, f.what);
    if (!f.mend.empty()) text += fmt::format("{:<20} mend: {}\n", "", f.mend);
  }
  return text;
}

}  // namespace plslam::doctor
