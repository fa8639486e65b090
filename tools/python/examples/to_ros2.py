#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""to_ros2.py [URL]: publishes the pose of the camera as /odom and /tf of ROS 2, in the axes of REP 103.

All frames have x forward, y left and z up, as the camera was held in its first image. Needs rclpy.
NOT TESTED by this project, whose tests run without ROS.
"""

import sys

import plslam
import rclpy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from tf2_ros import TransformBroadcaster

url = sys.argv[1] if len(sys.argv) > 1 else plslam.DEFAULT_URL
rclpy.init()
node = rclpy.create_node("plslam_odometry")
publisher = node.create_publisher(Odometry, "odom", 10)
broadcaster = TransformBroadcaster(node)


def fill(pose, position, orientation):
    """Turns x right, y down, z forward into x forward, y left, z up."""
    x, y, z = pose.position_m
    position.x, position.y, position.z = z, -x, -y
    w, x, y, z = pose.q_wxyz
    orientation.w, orientation.x, orientation.y, orientation.z = w, z, -x, -y


for message in plslam.listen(url, channels=["POSE"]):
    pose = message.value
    odometry = Odometry()
    odometry.header.stamp.sec, odometry.header.stamp.nanosec = divmod(pose.header.t_ns, 1_000_000_000)
    odometry.header.frame_id = "odom"
    odometry.child_frame_id = "camera_link"
    fill(pose.T_odom_c, odometry.pose.pose.position, odometry.pose.pose.orientation)
    publisher.publish(odometry)
    for parent, child, motion in (("map", "odom", pose.T_w_odom), ("odom", "camera_link", pose.T_odom_c)):
        stamped = TransformStamped()
        stamped.header.stamp = odometry.header.stamp
        stamped.header.frame_id, stamped.child_frame_id = parent, child
        fill(motion, stamped.transform.translation, stamped.transform.rotation)
        broadcaster.sendTransform(stamped)
