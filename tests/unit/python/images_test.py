# SPDX-License-Identifier: BSD-3-Clause
"""Images: ImageSender sends pairs of numpy arrays that the process adapter receives with every pixel."""

import json
import subprocess
import time

import numpy as np
import plslam
import pytest


@pytest.fixture
def receive(url, fixtures_program):
    """Calls `send` when the receiver of the C++ side is ready; returns the pair that it has received."""

    def receive_pair(send):
        with subprocess.Popen([fixtures_program, "receive", url], stdout=subprocess.PIPE, text=True) as receiver:
            try:
                assert receiver.stdout.readline() == "ready\n"
                send()
                return json.loads(receiver.stdout.readline())
            finally:
                receiver.kill()

    return receive_pair


def draw_pair(height, width):
    return np.random.default_rng(7).integers(0, 256, (2, height, width), dtype=np.uint8)


@pytest.mark.parametrize("height, width", [(48, 64), (240, 376)], ids=["one datagram", "several datagrams"])
def test_a_pair_arrives_with_every_pixel(receive, url, height, width):
    pair = draw_pair(height, width)
    received = receive(lambda: plslam.ImageSender(url).send(pair[0], pair[1], time_s=1_700_000_000.25))
    for image, sent in zip(received, pair):
        assert (image["height_px"], image["width_px"], image["encoding"]) == (height, width, "mono8")
        assert image["t_ns"] == 1_700_000_000_250_000_000
        assert image["bytes"] == sent.ravel().tolist()


def test_a_part_of_a_larger_image_may_be_sent(receive, url):
    """Such an array is not contiguous in memory."""
    pair = draw_pair(60, 90)[:, 5:45, 10:70]
    received = receive(lambda: plslam.ImageSender(url).send(pair[0], pair[1]))
    assert [image["bytes"] for image in received] == [image.ravel().tolist() for image in pair]


def test_without_a_time_images_are_of_now(receive, url):
    pair = draw_pair(4, 6)
    before_s = time.time()
    received = receive(lambda: plslam.ImageSender(url).send(pair[0], pair[1]))
    # The message has microseconds.
    assert before_s - 1e-6 <= 1e-9 * received[0]["t_ns"] <= time.time() + 1e-6


@pytest.mark.parametrize(
    "left, right",
    [
        (np.zeros((4, 6)), np.zeros((4, 6))),
        (np.zeros((4, 6, 3), np.uint8), np.zeros((4, 6, 3), np.uint8)),
        (np.zeros((4, 6), np.uint8), np.zeros((4, 7), np.uint8)),
    ],
    ids=["float", "colour", "two sizes"],
)
def test_other_arrays_are_refused(url, left, right):
    with pytest.raises(ValueError, match=r"^a pair is two arrays of uint8, \(height, width\), not "):
        plslam.ImageSender(url).send(left, right)


def test_other_urls_are_refused():
    with pytest.raises(ValueError, match="^tcpq://localhost:7700: images can only be sent to udpm://$"):
        plslam.ImageSender("tcpq://localhost:7700")
