#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""map_to_arrays.py MAP.plmap OUT.npz: points, lines and path of a map as arrays for Open3D and other programs.

    data = numpy.load("OUT.npz")
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(data["points"]))
    lines = open3d.geometry.LineSet(open3d.utility.Vector3dVector(data["line_ends"]),
                                    open3d.utility.Vector2iVector(data["lines"]))
"""

import sys

import numpy as np
import plslam

source, out = sys.argv[1:]
m = plslam.load_map(source)
# All ends in one array, and the pairs of its rows.
line_ends = np.stack([m.lines.p_w, m.lines.q_w], axis=1).reshape(-1, 3)
lines = np.arange(len(line_ends), dtype=np.int32).reshape(-1, 2)
np.savez(out, points=m.points.p_w, line_ends=line_ends, lines=lines, path=m.keyframes.T_w_kf[:, :3, 3])
print(f"{len(m.points.id)} points, {len(m.lines.id)} lines, {len(m.keyframes.id)} keyframes")
