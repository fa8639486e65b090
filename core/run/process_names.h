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
inline constexpr const char* kRecorder =
    "recorder";  ///< plslam run --record; outside of `kAll`, since it takes no orders
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

/// Counters of dense_process: its published messages, so that a reader knows whether more are on their way.
namespace dense_counter {
inline constexpr const char* kTiles = "grid.tiles";
inline constexpr const char* kSubmaps = "submaps.published";
}  // namespace dense_counter

/// Stages of processes (`stage_t.name`) that reports treat as sums.
namespace stage_name {
inline constexpr const char* kTotal = "total";    ///< a frame in vo_process
inline constexpr const char* kUpdate = "update";  ///< a keyframe in mapping_process
inline constexpr const char* kAdjust = "adjust";  ///< local bundle adjustment
}  // namespace stage_name

/// Arguments of `command_verb::kLocalise`.
namespace localise_mode {
inline constexpr const char* kOn = "on";    ///< the map is fixed
inline constexpr const char* kOff = "off";  ///< the map grows
}  // namespace localise_mode

/// Values of `stream_t.event`.
namespace stream_event {
inline constexpr const char* kBegin = "begin";
inline constexpr const char* kResume = "resume";  ///< by a player that continues after one that was killed
inline constexpr const char* kEnd = "end";
}  // namespace stream_event

/// Values of `run_t.event`.
namespace run_event {
inline constexpr const char* kBegin = "begin";
inline constexpr const char* kEnd = "end";
}  // namespace run_event

/// Values of `stream_t.pace`, and of the options `pace`.
namespace stream_pace {
inline constexpr const char* kLockstep = "lockstep";
inline constexpr const char* kRealtime = "realtime";  ///< as an option, a speed may follow: "realtimex2"
}  // namespace stream_pace

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
