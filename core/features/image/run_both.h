// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace plslam {

/// Runs two pieces of work that do not touch each other's data, and returns when both are done: side by side where
/// the caller has a second thread, in turn otherwise. The result does not depend on which.
using RunBoth = std::function<void(const std::function<void()>&, const std::function<void()>&)>;

inline void RunInTurn(const std::function<void()>& first, const std::function<void()>& second) {
  first();
  second();
}

}  // namespace plslam
