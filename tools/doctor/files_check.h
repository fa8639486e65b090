// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "tools/doctor/finding.h"

namespace plslam {

/// Whether files can be written to `folder` (or to where it will be made), and how much of them. `use` says what for
/// ("histories", "outputs"), `mend` how to choose another folder.
Findings CheckFolder(const std::filesystem::path& folder, const std::string& use, const std::string& mend);

/// Whether the vocabulary `name` (of `kind`, "points" or "lines") is where loop_process looks for it, and whole.
/// `key`: the option that names it.
Findings CheckVocabulary(const std::string& name, const std::string& kind, const std::string& key);

/// Whether the programs of the system stand beside this one.
Findings CheckPrograms();

}  // namespace plslam
