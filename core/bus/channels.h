// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace plslam::bus {

/// `header_t.schema` of every message; messages with another are rejected and counted.
inline constexpr int32_t kSchemaVersion = 1;

/// How a channel is delivered. kEvery: ordered and gap-free for each publisher, repaired from its history.
/// kLatest: the newest wins.
enum class Delivery { kEvery, kLatest };

/// The messages of an ordered channel that its publisher retains. kAll: from the first message on, spilled to disk
/// beyond a bound. kUnacknowledged: until every reader that has acknowledged any message has them (a bounded window).
enum class Retention { kNone, kUnacknowledged, kAll };

/// The prefix of a channel if several robots share a map (`BusOptions::map_prefix`); for one robot all prefixes are the
/// same.
enum class Scope {
  kRobot,    ///< the robot's own
  kMap,      ///< the map's: between trackers and the owners of the map
  kToMap,    ///< sent under both, read under the own prefix: the messages of a robot that the owners of the map need
  kFromMap,  ///< sent under the own prefix, read under both: the processes that are running
};

/// Whether a publisher waits for slow readers. kFree: only as far as the window of an ordered channel requires. kPaced:
/// readers acknowledge big unordered messages, so that the publisher is not much ahead of them. kLockstep: the
/// publisher waits for readers as long as they make progress.
enum class Pace { kFree, kPaced, kLockstep };

/// One row of the channel table, which lcmtypes/README.md and the tests read too.
struct Channel {
  std::string_view name;
  std::string_view type;
  std::string_view publisher;
  Delivery delivery;
  Retention retention;
  std::string_view meaning;
  Scope scope = Scope::kRobot;
  Pace pace = Pace::kFree;
};

inline constexpr Channel kCamera{
    "CAMERA", "camera_t", "player", Delivery::kLatest, Retention::kNone, "the complete rig, at 1 Hz", Scope::kToMap};
inline constexpr Channel kStream{"STREAM",         "stream_t",      "player",
                                 Delivery::kEvery, Retention::kAll, "begin and end of a stream of frames"};
inline constexpr Channel kRun{
    "RUN", "run_t", "plslam", Delivery::kEvery, Retention::kAll, "begin and end of a run of `plslam run`"};
inline constexpr Channel kStereoFrame{"STEREO_FRAME",
                                      "image_strip_t",
                                      "player",
                                      Delivery::kEvery,
                                      Retention::kUnacknowledged,
                                      "frames in lockstep, in strips",
                                      Scope::kRobot,
                                      Pace::kLockstep};
inline constexpr Channel kStereoFrameLive{"STEREO_FRAME_LIVE", "image_strip_t",  "player",
                                          Delivery::kLatest,   Retention::kNone, "frames in real time, in strips",
                                          Scope::kRobot,       Pace::kPaced};
inline constexpr Channel kGroundTruth{"GROUND_TRUTH",   "ground_truth_t", "player",
                                      Delivery::kEvery, Retention::kAll,  "true poses, for evaluation only"};
inline constexpr Channel kPose{
    "POSE",           "pose_t",        "vo",
    Delivery::kEvery, Retention::kAll, "the pose of every frame; acknowledges it in lockstep"};
inline constexpr Channel kTracks{"TRACKS",
                                 "tracks_t",
                                 "vo",
                                 Delivery::kEvery,
                                 Retention::kUnacknowledged,
                                 "features of a frame in lockstep, for pictures"};
inline constexpr Channel kTracksLive{"TRACKS_LIVE",     "tracks_t",       "vo",
                                     Delivery::kLatest, Retention::kNone, "features of a frame in real time"};
inline constexpr Channel kBodies{"BODIES",
                                 "bodies_t",
                                 "vo",
                                 Delivery::kEvery,
                                 Retention::kUnacknowledged,
                                 "moving bodies, for frames that observe some"};
inline constexpr Channel kKeyframe{
    "KEYFRAME",       "keyframe_t",    "vo",
    Delivery::kEvery, Retention::kAll, "keyframes, in pages (mapping: those of a loaded map)",
    Scope::kMap};
inline constexpr Channel kMapUpdate{"MAP_UPDATE",
                                    "map_update_t",
                                    "mapping",
                                    Delivery::kEvery,
                                    Retention::kUnacknowledged,
                                    "changes of the map, or the complete map, in pages",
                                    Scope::kMap};
inline constexpr Channel kMapRequest{"MAP_REQUEST",     "map_request_t",  "all",
                                     Delivery::kLatest, Retention::kNone, "request for the complete map",
                                     Scope::kMap};
inline constexpr Channel kLoopClosure{
    "LOOP_CLOSURE",   "loop_closure_t", "loop",
    Delivery::kEvery, Retention::kAll,  "loops and corrections of the map, in pages; one answer per keyframe",
    Scope::kMap};
inline constexpr Channel kRelocalisationRequest{"RELOCALISATION_REQUEST",
                                                "keyframe_t",
                                                "vo",
                                                Delivery::kEvery,
                                                Retention::kUnacknowledged,
                                                "relocalisation request: features of a frame, in pages",
                                                Scope::kMap};
inline constexpr Channel kRelocalisation{
    "RELOCALISATION", "relocalisation_t",         "loop",
    Delivery::kEvery, Retention::kUnacknowledged, "answers to RELOCALISATION_REQUEST",
    Scope::kMap};
inline constexpr Channel kStatus{"STATUS",          "status_t",       "all",
                                 Delivery::kLatest, Retention::kNone, "health of each process, at 1 Hz",
                                 Scope::kFromMap};
inline constexpr Channel kWarning{"WARNING",       "warning_t",
                                  "all",           Delivery::kEvery,
                                  Retention::kAll, "conditions that can make results wrong or incomplete, each once",
                                  Scope::kFromMap};
inline constexpr Channel kCommand{
    "COMMAND", "command_t", "plslam, vo", Delivery::kEvery, Retention::kUnacknowledged, "commands to processes"};
inline constexpr Channel kCommandAnswer{"COMMAND_ANSWER", "command_answer_t",         "mapping, player",
                                        Delivery::kEvery, Retention::kUnacknowledged, "results of commands"};
inline constexpr Channel kGrid{"GRID",           "grid_t",        "dense",
                               Delivery::kEvery, Retention::kAll, "tiles of the occupancy grid that have changed"};
inline constexpr Channel kSubmap{"SUBMAP",        "submap_t",
                                 "dense",         Delivery::kEvery,
                                 Retention::kAll, "submaps whose surface points have changed, in pages"};
inline constexpr Channel kMask{"MASK",
                               "mask_t",
                               "detector of yours",
                               Delivery::kEvery,
                               Retention::kUnacknowledged,
                               "masks of the images of a frame"};
inline constexpr Channel kRobotMotion{"ROBOT_MOTION",
                                      "robot_motion_t",
                                      "adapter",
                                      Delivery::kEvery,
                                      Retention::kUnacknowledged,
                                      "poses from the robot's wheels around the time of a frame, for prediction"};
inline constexpr Channel kImu{"IMU",
                              "imu_t",
                              "player",
                              Delivery::kEvery,
                              Retention::kUnacknowledged,
                              "samples of the inertial sensor, sent before the frame that they lead to"};
inline constexpr Channel kRepairRequest{
    "REPAIR_REQUEST",  "repair_request_t", "all",
    Delivery::kLatest, Retention::kNone,   "acknowledgements and resend requests"};
inline constexpr Channel kAnnounce{
    "ANNOUNCE",        "announce_t",     "all",
    Delivery::kLatest, Retention::kNone, "contents of the publishers of ordered channels"};

/// All rows.
std::span<const Channel> Channels();

}  // namespace plslam::bus
