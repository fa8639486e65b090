#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""live_plot.py [URL]: draws the path of the camera from above during a run (needs matplotlib)."""

import sys

import matplotlib.pyplot as plt
import plslam

url = sys.argv[1] if len(sys.argv) > 1 else plslam.DEFAULT_URL
x, z = [], []
(line,) = plt.plot(x, z)
plt.gca().set_aspect("equal")
plt.xlabel("x [m]")
plt.ylabel("z [m]")
plt.ion()
plt.show()
for message in plslam.listen(url, channels=["POSE"], timeout_s=30):
    T_w_c = plslam.transform(message.value.T_w_odom) @ plslam.transform(message.value.T_odom_c)
    x.append(T_w_c[0, 3])
    z.append(T_w_c[2, 3])
    if len(x) % 10 == 0:
        line.set_data(x, z)
        plt.gca().relim()
        plt.gca().autoscale_view()
        plt.pause(0.001)
