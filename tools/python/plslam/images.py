# SPDX-License-Identifier: BSD-3-Clause
"""Stereo pairs as messages of LCM (`bot_core.images_t`) for the process `adapter`, sent without LCM."""

import socket
import struct
import time
import urllib.parse
from typing import Optional

import numpy as np

from .wire import DEFAULT_URL

# Of LCM: bot_core.images_t, and the numbers before the parts of a message.
_FINGERPRINT = bytes.fromhex("20ba4f05e8f5e33a")
_FRAGMENT = b"LC03"
_FRAGMENT_BYTES = 60_000
_GREY = 1497715271  # the pixel format


class ImageSender:
    """Sends pairs of images to `adapter --images CHANNEL --camera camera.yaml`, over `udpm://`.

    Images are sent as they come, and are not repeated if the network loses them.
    """

    def __init__(self, url: str = DEFAULT_URL, channel: str = "CAMERA") -> None:
        parts = urllib.parse.urlsplit(url)
        if parts.scheme != "udpm":
            raise ValueError(f"{url}: images can only be sent to udpm://")
        self._to = (parts.hostname or "239.255.76.67", parts.port or 7667)
        self._channel = channel.encode("ascii") + b"\0"
        self._n = 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM, socket.IPPROTO_UDP)
        ttl = int(urllib.parse.parse_qs(parts.query).get("ttl", ["0"])[0])
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)

    def send(self, left: np.ndarray, right: np.ndarray, time_s: Optional[float] = None) -> None:
        """Sends two grey images (height, width) of uint8, as the cameras took them at `time_s`, seconds since 1970 (now)."""
        utime = round(1e6 * (time.time() if time_s is None else time_s))
        body = [_FINGERPRINT, struct.pack(">qihh", utime, 2, 0, 1)]
        for image in (left, right):
            if image.ndim != 2 or image.dtype != np.uint8 or image.shape != left.shape:
                raise ValueError(f"a pair is two arrays of uint8, (height, width), not {image.dtype} of {image.shape}")
            height, width = image.shape
            head = struct.pack(">qiiiii", utime, width, height, width, _GREY, image.size)
            body += [head, image.tobytes(), struct.pack(">i", 0)]
        self._send(b"".join(body))

    def _send(self, message: bytes) -> None:
        """Sends the fragments of a message; the first one has the name of the channel."""
        parts = [message[at : at + _FRAGMENT_BYTES] for at in range(0, len(message), _FRAGMENT_BYTES)]
        for i, part in enumerate(parts):
            head = struct.pack(">IIIHH", self._n, len(message), i * _FRAGMENT_BYTES, i, len(parts))
            self._socket.sendto(_FRAGMENT + head + (self._channel if i == 0 else b"") + part, self._to)
        self._n = (self._n + 1) % 2**32
