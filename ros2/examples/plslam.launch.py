# SPDX-License-Identifier: BSD-3-Clause
"""Starts plslam on a robot of ROS 2: ros2 launch ./plslam.launch.py left:=/left/image_raw right:=/right/image_raw."""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration


def generate_launch_description():
    arguments = {
        "left": "/stereo/left/image_raw",
        "right": "/stereo/right/image_raw",
        "out": "plslam_run",
        "publish_tf": "all",  # map: the robot publishes odom to base_link
        "base_frame": "base_link",
    }
    given = {name: LaunchConfiguration(name) for name in arguments}
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=value) for name, value in arguments.items()]
        + [
            ExecuteProcess(
                cmd=[
                    "plslam",
                    "run",
                    ["ros2:", given["left"], ",", given["right"]],
                    "--out",
                    given["out"],
                    "--force",
                    "--set",
                    ["ros2.publish_tf=", given["publish_tf"]],
                    "--set",
                    ["ros2.base_frame=", given["base_frame"]],
                ],
                sigterm_timeout="20",  # the results are being written
                output="screen",
            )
        ]
    )
