#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""write_bag.py FOLDER FILE.bag COMPRESSION [png] [odometry] [unsorted] [killed]: writes a folder of images (camera.yaml of
a rectified pair, times.txt, groundtruth.txt) as a bag with ROS 1's own library: raw images, camera_info, and the true
poses as PoseStamped; or CompressedImage, Odometry, frames from the last to the first, and a bag that is not closed."""
import os
import pathlib
import re
import struct
import sys
import zlib

import genpy
import geometry_msgs.msg
import nav_msgs.msg
import rosbag
import sensor_msgs.msg


def size_of(png):
    """Returns width and height of a PNG of 8 bits and one channel."""
    width, height, depth, colour = struct.unpack(">IIBB", png[16:26])
    if (depth, colour) != (8, 0):
        raise SystemExit("an image has not 8 bits of grey")
    return width, height


def pixels_of(png):
    width, height = size_of(png)
    packed, at = b"", 8
    while at < len(png):
        (n,) = struct.unpack(">I", png[at : at + 4])
        if png[at + 4 : at + 8] == b"IDAT":
            packed += png[at + 8 : at + 8 + n]
        at += 12 + n
    raw = zlib.decompress(packed)
    above = bytearray(width)
    pixels = bytearray()
    for y in range(height):
        row_filter, row = raw[y * (width + 1)], bytearray(raw[y * (width + 1) + 1 : (y + 1) * (width + 1)])
        for x in range(width):
            a, b, c = (row[x - 1], above[x], above[x - 1]) if x else (0, above[x], 0)
            if row_filter == 4:
                p = a + b - c
                pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
                predicted = a if pa <= pb and pa <= pc else b if pb <= pc else c
            else:
                predicted = (0, a, b, (a + b) >> 1)[row_filter]
            row[x] = (row[x] + predicted) & 255
        pixels += row
        above = row
    return bytes(pixels)


def time_of(text):
    seconds, _, decimals = text.partition(".")
    return genpy.Time(int(seconds), int(decimals[:9].ljust(9, "0")))


def main():
    folder, compression, options = pathlib.Path(sys.argv[1]), sys.argv[3], sys.argv[4:]
    yaml = (folder / "camera.yaml").read_text()

    def numbers(key):
        return [float(x) for x in re.search(key + r": \[?([-0-9.e, ]+)", yaml)[1].split(",")]

    (fx, fy), (cx, cy), (b,) = numbers("focal_length_px"), numbers("principal_point_px"), numbers("baseline_m")
    with rosbag.Bag(sys.argv[2], "w", compression=compression, chunk_threshold=300_000) as bag:
        times = list(enumerate((folder / "times.txt").read_text().split()))
        for i, text in reversed(times) if "unsorted" in options else times:
            time = time_of(text)
            for side in ("right", "left"):
                png = sorted((folder / side).iterdir())[i].read_bytes()
                width, height = size_of(png)
                info = sensor_msgs.msg.CameraInfo(width=width, height=height, distortion_model="plumb_bob", D=[0.0] * 5)
                info.K = [fx, 0, cx, 0, fy, cy, 0, 0, 1]
                info.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
                info.P = [fx, 0, cx, -fx * b if side == "right" else 0, 0, fy, cy, 0, 0, 0, 1, 0]
                if "png" in options:
                    topic = "image_raw/compressed"
                    image = sensor_msgs.msg.CompressedImage(format="mono8; png compressed ", data=png)
                else:
                    topic = "image_raw"
                    image = sensor_msgs.msg.Image(width=width, height=height, encoding="mono8", step=width)
                    image.data = pixels_of(png)
                for name, message in (("camera_info", info), (topic, image)):
                    message.header.stamp, message.header.frame_id = time, "camera"
                    bag.write(f"/stereo/{side}/{name}", message, time)
        for row in (folder / "groundtruth.txt").read_text().splitlines():
            if row.startswith("#"):
                continue
            text, *pose = row.split()
            odometry = "odometry" in options
            message = nav_msgs.msg.Odometry() if odometry else geometry_msgs.msg.PoseStamped()
            message.header.stamp = time_of(text)
            true_pose = message.pose.pose if odometry else message.pose
            p, q = true_pose.position, true_pose.orientation
            p.x, p.y, p.z, q.x, q.y, q.z, q.w = map(float, pose)
            bag.write("/gt/odom" if odometry else "/ground_truth", message, message.header.stamp)
        if "killed" in options:
            bag.flush()
            sys.stdout.flush()
            os._exit(0)


if __name__ == "__main__":
    main()
