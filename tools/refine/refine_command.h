// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam::refine {

/// Adds `plslam refine`, which, when chosen, sets `*command`.
void AddRefineCommand(CLI::App* app, std::function<int()>* command);

}  // namespace plslam::refine
