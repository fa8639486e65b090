// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/run/run_warnings.h"
#include "tools/plslam/progress_line.h"
#include "tools/plslam/run_options.h"

namespace plslam::launcher {

/// The sentences of a run on stderr, each once, and its progress line below them. Warnings and restarts are printed in
/// a quiet run, too.
class RunConsole {
 public:
  explicit RunConsole(const RunOptions& options);

  /// Prints the warnings after those of the last call, at once: a run of a robot may take days.
  void PrintNew(const std::vector<RunWarning>& warnings);
  /// Prints the reason why there are no frames yet, if it is another one than before.
  void PrintAwaited(const std::string& reason);
  void PrintStop(const std::string& what);
  void PrintRestart(const std::string& process, const std::string& how, int restart);
  void Show(const Progress& progress) { line_.Show(progress); }
  void Clear() { line_.Clear(); }

 private:
  bool quiet_;
  int max_restarts_;
  ProgressLine line_;
  size_t n_warnings_ = 0;  ///< printed
  std::string awaited_;    ///< printed last
};

}  // namespace plslam::launcher
