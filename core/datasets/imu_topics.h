// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace plslam {

/// The topics of sensor_msgs/Imu of one sensor. Drivers of RealSense cameras publish rates and forces apart, on
/// .../gyro/sample and .../accel/sample; each message then has only one of the two.
struct ImuTopics {
  std::string rates;
  std::string forces;  ///< the same topic if its messages have both

  bool are_apart() const { return rates != forces; }
  bool operator==(const ImuTopics&) const = default;
};

/// Returns the topics of a sensor by the name of one: /camera/gyro/sample and /camera/accel/sample by either of them,
/// any other topic as it is.
ImuTopics ImuTopicsOf(const std::string& topic);

/// Returns the sensors among topics of sensor_msgs/Imu: those of complete messages before those whose topics are apart,
/// each in order of their names. Rates without forces, or forces without rates, are none.
std::vector<ImuTopics> ImuTopicsAmong(const std::set<std::string>& topics);

/// Chooses the sensor of a camera: the one whose topic shares the most leading parts of its name with that of the
/// images ("/camera/imu" with "/camera/infra1/image_rect_raw"), and the first of several such. `sensors` is not empty.
ImuTopics NearestImu(const std::vector<ImuTopics>& sensors, std::string_view image_topic);

}  // namespace plslam
