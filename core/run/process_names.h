// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>

namespace plslam {

/// Names of the processes in `status_t.process` and `command_t.target`.
namespace process_name {
inline constexpr const char* kPlayer = "player";
inline constexpr const char* kCamera = "camera";  ///< replaces the player
inline constexpr const char* kAdapter = "adapter";
inline constexpr const char* kRos2 = "ros2";
inline constexpr const char* kVo = "vo";
inline constexpr const char* kMapping = "mapping";
inline constexpr const char* kLoop = "loop";
inline constexpr const char* kViewer = "viewer";
inline constexpr const char* kDense = "dense";
inline constexpr const char* kBridge = "bridge";
inline constexpr std::array kAll = {kPlayer, kCamera, kAdapter, kVo,     kMapping,
                                    kLoop,   kViewer, kDense,   kBridge, kRos2};
inline bool SendsFrames(std::string_view name) {
  return name == kPlayer || name == kCamera || name == kAdapter || name == kRos2;
}
}  // namespace process_name

/// Values of `status_t.state`, in their usual order; any state may be followed by failed.
namespace process_state {
inline constexpr const char* kStarting = "starting";
inline constexpr const char* kReady = "ready";
inline constexpr const char* kRunning = "running";
inline constexpr const char* kFinished = "finished";  ///< end of stream handled, outputs written
inline constexpr const char* kStopping = "stopping";
inline constexpr const char* kFailed = "failed";
inline constexpr std::array kAll = {kStarting, kReady, kRunning, kFinished, kStopping, kFailed};
}  // namespace process_state

/// Values of `command_t.verb`; documented in lcmtypes/command_t.lcm.
namespace command_verb {
inline constexpr const char* kFinish = "finish";
inline constexpr const char* kGoBack = "go_back";
inline constexpr const char* kSave = "save";
inline constexpr const char* kReset = "reset";
inline constexpr const char* kLoad = "load";
inline constexpr const char* kLocalise = "localise";
inline constexpr const char* kPause = "pause";
inline constexpr const char* kResume = "resume";
inline constexpr const char* kSendKeyframes = "send_keyframes";
/// In front of the file of "save": replace a file that is not an older state of this map.
inline constexpr const char* kForce = "--force ";
inline constexpr std::array kAll = {kFinish,   kGoBack, kSave,   kReset,        kLoad,
                                    kLocalise, kPause,  kResume, kSendKeyframes};
}  // namespace command_verb

}  // namespace plslam
