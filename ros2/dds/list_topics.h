// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam::ros2 {

/// Listens for four seconds, and prints the topics of the domain of the environment. Returns the exit code: 1, with a
/// sentence on standard error, if there are none, or the domain cannot be joined.
int ListTopics();

}  // namespace plslam::ros2
