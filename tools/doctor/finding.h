// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam::doctor {

/// kAdvice: it works, and would work better. kProblem: something does not work.
enum class Verdict { kGood, kAdvice, kProblem };

/// "good", "advice", "problem".
const char* VerdictName(Verdict verdict);

/// Result of one check of this host.
struct Finding {
  std::string check;  ///< "multicast", "buffer", "port", "clock", "process", "disk", "vocabulary"
  Verdict verdict = Verdict::kGood;
  std::string what;  ///< one sentence
  std::string mend;  ///< command that mends it; empty if there is no problem
};

using Findings = std::vector<Finding>;

Finding Good(const std::string& check, const std::string& what);
Finding Advice(const std::string& check, const std::string& what, const std::string& mend);
Finding Problem(const std::string& check, const std::string& what, const std::string& mend);

/// Returns `command` as a user who is not root enters it.
std::string AsRoot(const std::string& command);

bool HasProblem(const Findings& findings);

/// Returns one line for each finding and one below it for its command; `only_bad` leaves out good findings.
std::string FindingsToText(const Findings& findings, bool only_bad);

}  // namespace plslam::doctor
