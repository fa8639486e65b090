// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/datasets/imu_topics.h"
#include "core/datasets/recordings/message_times.h"
#include "core/datasets/recordings/recording.h"
#include "core/files/notes.h"
#include "core/geometry/imu.h"
#include "core/geometry/se3.h"

namespace plslam {

/// Returns the sensors of a recording: its topics of sensor_msgs/Imu.
std::vector<ImuTopics> ImuTopicsOf(const Recording& recording);

/// Returns the frame of the first message with rates; empty if there is none.
std::string FrameOfImu(const Recording& recording, const ImuTopics& topics);

/// Reads the samples in a part of the file, in order of increasing header stamps. Messages of the same stamp as
/// another one, without a stamp, damaged ones and ones without a measurement are skipped; `notes` reports them. Rates
/// and forces that are apart are joined (core/datasets/imu_join.h). Throws DatasetError if no sample is left.
std::vector<ImuSample> ReadRecordedImu(const Recording& recording, const ImuTopics& topics, const FileRange& range,
                                       Notes* notes);

/// Returns the pose of the frame `b` in the frame `a` by the transforms on /tf_static; nullopt if they do not connect
/// both, or one has no name. Damaged messages are skipped.
std::optional<SE3> RecordedTransform(const Recording& recording, const std::string& a, const std::string& b);

}  // namespace plslam
