// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/result_folder.h"

#include <utility>

#include "core/run/run_writer.h"

namespace plslam::viewer {

ResultFolder::ResultFolder(const std::string& path, Earlier earlier) : path_(path), earlier_(earlier) {
  PrepareOutputFolder(path_);
  lock_.emplace(path_);
  if (earlier_ == Earlier::kRefuse) CheckHasNoResults(path_);
}

void ResultFolder::RemoveEarlier() {
  if (std::exchange(replaces_, false)) RemoveResults(path_);
}

void ResultFolder::ReplaceOwn() {
  if (earlier_ == Earlier::kRefuse) earlier_ = Earlier::kReplace;
}

}  // namespace plslam::viewer
