# SPDX-License-Identifier: BSD-3-Clause
"""Maps, runs, logs and live messages of plslam, with numpy only.

    for message in plslam.listen():            # live messages of the processes
    for message in plslam.read_log("run.lcm"): # recorded messages
    plslam.ImageSender().send(left, right)     # images for `adapter`
    plslam.Odometry("camera.yaml").track(left, right, t_ns)  # poses, computed in this process
    run = plslam.load_run("out/room")          # trajectories and figures of a run
    map = plslam.load_map("room.plmap")        # keyframes, landmarks and observations as arrays
    grid = plslam.read_grid("out/room")        # floor and surfaces of dense_process

Message types are generated from the .lcm files: plslam.pose_t, plslam.status_t, ... Everything is metres, radians and
pixels; T_w_c takes points of c to w. See docs/python.md.
"""

# The generated types refer to each other as plslam.NAME, so they are imported first.
from .messages import *  # noqa: F401,F403
from .errors import FileError
from .images import ImageSender
from .log import read_log
from .map_file import Camera, Features, Keyframes, Lines, Map, Points, load_map
from .odometry import Odometry, TrackedPose
from .run import Run, Trajectory, load_run, read_covariances, read_trajectory
from .surfaces import Grid, Surface, read_grid, read_surface
from .wire import DEFAULT_URL, Message, listen, transform
