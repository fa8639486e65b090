// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/output_folder.h"

#include <system_error>

#include "core/io/files/atomic_file.h"
#include "tools/plslam/process_table.h"

namespace plslam {
namespace {

using std::filesystem::path;

/// The outermost folder on the way to this one that there is not; empty where there is this one.
path FirstMissing(const path& folder) {
  path missing;
  std::error_code ignored;
  for (path each = folder; !std::filesystem::exists(each, ignored); each = each.parent_path()) missing = each;
  return missing;
}

path Absolute(const path& folder) {
  const path absolute = std::filesystem::absolute(folder).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();  // without a slash at its end
}

}  // namespace

OutputFolder::OutputFolder(const path& folder)
    : folder_(Absolute(folder)), first_made_(FirstMissing(folder_ / "logs")) {
  try {
    MakeFolder(folder.string());
    lock_.emplace(folder.string());
    MakeFolder((folder / "logs").string());
  } catch (const std::exception&) {
    Remove();
    throw;
  }
}

OutputFolder::~OutputFolder() {
  if (!kept_) Remove();
}

bool OutputFolder::has_results() const { return std::filesystem::exists(folder_ / "summary.json"); }

void OutputFolder::Remove() const {
  if (!lock_) return;
  std::error_code ignored;
  for (const ProcessRow& row : ProcessTable()) {
    std::filesystem::remove(folder_ / "logs" / (std::string(row.name) + ".log"), ignored);
  }
  if (first_made_.empty()) return;
  // Only what is empty goes.
  for (path each = folder_ / "logs"; each != first_made_.parent_path(); each = each.parent_path()) {
    std::filesystem::remove(each, ignored);
  }
}

}  // namespace plslam
