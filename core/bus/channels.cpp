// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/channels.h"

#include <array>

namespace plslam::bus {

std::span<const Channel> Channels() {
  static constexpr std::array kRows = {
      kCamera,         kStream,    kRun,        kStereoFrame,   kStereoFrameLive,
      kGroundTruth,    kPose,      kTracks,     kTracksLive,    kBodies,
      kKeyframe,       kMapUpdate, kMapRequest, kLoopClosure,   kRelocalisationRequest,
      kRelocalisation, kStatus,    kCommand,    kCommandAnswer, kWarning,
      kGrid,           kSubmap,    kMask,       kRobotMotion,   kImu,
      kRepairRequest,  kAnnounce};
  return kRows;
}

}  // namespace plslam::bus
