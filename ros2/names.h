// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace plslam::ros2 {

// Names of ROS 2 in DDS: the topic /odom is "rt/odom", and the type nav_msgs/msg/Odometry
// "nav_msgs::msg::dds_::Odometry_".

/// `topic` begins with "/".
std::string DdsTopicName(std::string_view topic);
/// Returns an empty text for names that are no topics of ROS (services and others).
std::string RosTopicName(std::string_view dds_name);

std::string DdsTypeName(std::string_view type);
/// Returns the name in DDS for types that are not of ROS.
std::string RosTypeName(std::string_view dds_type);

/// Names of a service: /save of std_srvs/srv/Trigger has the topics "rq/saveRequest" and "rr/saveReply", of the types
/// "std_srvs::srv::dds_::Trigger_Request_" and "..._Response_".
struct ServiceNames {
  std::string request, request_type, reply, reply_type;
};
ServiceNames DdsServiceNames(std::string_view service, std::string_view type);

/// The topic as a node in this namespace names it: "odom" in "/robot" is "/robot/odom", and "/odom" stays.
std::string InNamespace(std::string_view space, std::string_view topic);

/// Returns the name of the frame of the rectified left camera: as given; if empty, camera_left with the prefix of the
/// body's frame ("one/base_link": "one/camera_left"), since all robots of a domain share /tf_static.
std::string CameraFrameOf(std::string_view base_frame, std::string_view given);

/// Returns the reason why a text is no name of a topic ("has no / at the begin"); empty if it is.
std::string TopicNameComplaint(std::string_view topic);

}  // namespace plslam::ros2
