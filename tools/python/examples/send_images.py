#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""send_images.py [URL]: feeds stereo pairs of numpy to plslam, as the driver of a camera would, 20 a second.

Here they show a wall, 2 m away, along which two cameras move to the right at 0.4 m/s (camera.yaml: 200 px, 0.1 m).
Beside it run vo_process, the other processes, and

    adapter --images CAMERA --camera camera.yaml --foreign-url URL
"""

import sys
import time

import numpy as np

import plslam

WIDTH, HEIGHT, DISPARITY, STEP = 376, 240, 10, 2  # pixels: 200 px * 0.1 m / 2 m, and 2 px a frame: 2 cm
grains = np.random.default_rng(7).integers(0, 256, (HEIGHT // 6, 400), dtype=np.uint8)
wall = np.kron(grains, np.ones((6, 6), np.uint8))

sender = plslam.ImageSender(sys.argv[1] if len(sys.argv) > 1 else plslam.DEFAULT_URL)
begin = time.time()
for frame in range(200):
    x, taken = STEP * frame, begin + frame / 20
    time.sleep(max(0, taken - time.time()))
    sender.send(wall[:, x : x + WIDTH], wall[:, x + DISPARITY : x + DISPARITY + WIDTH], taken)
