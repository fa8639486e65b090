#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""compute_odometry.py [FOLDER]: odometry of numpy images in this process, without a bus.

The images show a wall, 2 m away, along which two cameras move to the right by 2 cm a frame. With FOLDER, they are also
recorded there, as a dataset (plslam run FOLDER --no-mapping).
"""

import os
import sys
import tempfile

import numpy as np

import plslam

WIDTH, HEIGHT, DISPARITY, STEP = 376, 240, 10, 2  # pixels: 200 px * 0.1 m / 2 m, and 2 px a frame: 2 cm
CAMERA = f"""rate_hz: 20
baseline_m: 0.1
left:
  resolution_px: [{WIDTH}, {HEIGHT}]
  focal_length_px: [200, 200]
  principal_point_px: [187.5, 119.5]
"""
grains = np.random.default_rng(7).integers(0, 256, (HEIGHT // 6, 100), dtype=np.uint8)
wall = np.kron(grains, np.ones((6, 6), np.uint8))

with tempfile.TemporaryDirectory() as folder:
    camera = os.path.join(folder, "camera.yaml")
    with open(camera, "w") as file:
        file.write(CAMERA)
    odometry = plslam.Odometry(camera)

if len(sys.argv) > 1:
    odometry.record(sys.argv[1])
for frame in range(40):
    x = STEP * frame
    left, right = wall[:, x : x + WIDTH], wall[:, x + DISPARITY : x + DISPARITY + WIDTH]
    pose = odometry.track(left, right, frame * 50_000_000)
    print(frame, pose.state, pose.T_odom_c[:3, 3].round(4), "sigma", np.sqrt(np.diag(pose.covariance)[:3]).round(4))
