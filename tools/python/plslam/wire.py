# SPDX-License-Identifier: BSD-3-Clause
"""Messages from the bus: LCM's datagrams, received without LCM.

Each message of plslam is one datagram: the magic number of LCM's short messages, a number, the name of the channel,
and the encoded struct. A listener therefore needs only a socket that has joined the multicast group.
"""

import collections
import socket
import struct
import time
import urllib.parse
import warnings
from typing import Any, Collection, Dict, Iterator, NamedTuple, Optional, Tuple

import numpy as np

from . import messages

DEFAULT_URL = "udpm://239.255.76.67:7667?ttl=0"

_SHORT_MESSAGE = b"LC02"
_HEAD_BYTES = 8
_MAX_DATAGRAM = 65536
# Ordered messages are resent if a reader has lost one. This many numbers of a publisher are remembered.
_REMEMBERED = 10000


class Message(NamedTuple):
    """A decoded message: `value` is a struct of plslam (pose_t, status_t, ...)."""

    channel: str  # without the prefix
    time_s: float  # when it was received or recorded, seconds since 1970; the time of its data is value.header.t_ns
    value: Any


def _types() -> Dict[bytes, Any]:
    found = {}
    for name in dir(messages):
        kind = getattr(messages, name)
        if hasattr(kind, "_get_packed_fingerprint") and hasattr(kind(), "header"):
            found[kind._get_packed_fingerprint()] = kind
    return found


_TYPE_OF_FINGERPRINT = _types()

# Most channels have the name of their type.
_CHANNELS = {kind.__name__[: -len("_t")].upper() for kind in _TYPE_OF_FINGERPRINT.values()} | {
    "STEREO_FRAME",
    "STEREO_FRAME_LIVE",
    "TRACKS_LIVE",
    "RELOCALISATION_REQUEST",
}
_MAX_SCHEMA = 99


def decode(data: bytes) -> Optional[Any]:
    """Returns the struct encoded in the bytes; None if they are not of a message type of this version.

    Bytes after the message, such as a MAC, are ignored. Raises ValueError for bytes that begin like one of our
    messages but are invalid.
    """
    kind = _TYPE_OF_FINGERPRINT.get(bytes(data[:8]))
    if kind is None:
        return None
    try:
        return kind.decode(data)
    except (struct.error, ValueError, IndexError, UnicodeDecodeError, MemoryError, OverflowError) as error:
        raise ValueError(f"not a {kind.__name__}: {error}") from error


def warn_of_version(where: str, name: str, data: bytes) -> None:
    """Warns about bytes that are not of a type of this version, if the channel has the name of one of ours and the
    position of the schema contains a small number (other programs have a POSE, too). Python shows the warning once."""
    if name in _CHANNELS and 0 < int.from_bytes(data[8:12], "big") <= _MAX_SCHEMA:
        warnings.warn(
            f"{where}: {name} is from another version of plslam and skipped: use the package of that version, "
            "or recompute the run of a log (plslam replay)",
            stacklevel=3,
        )


def without_prefix(channel: str, prefix: str, channels: Optional[Collection[str]]) -> Optional[str]:
    """Returns the name of the channel without the prefix; None if it is another robot's or not in `channels`."""
    if not channel.startswith(prefix):
        return None
    name = channel[len(prefix) :]
    # Our channel names are upper case: the rest of another robot's longer prefix is not.
    if not name.replace("_", "").isupper() or (channels is not None and name not in channels):
        return None
    return name


def parse_datagram(datagram: bytes) -> Optional[Tuple[str, bytes]]:
    """Returns channel and content of a short message of LCM; None for everything else."""
    if datagram[:4] != _SHORT_MESSAGE:
        return None
    end = datagram.find(b"\0", _HEAD_BYTES)
    if end < 0:
        return None
    try:
        return datagram[_HEAD_BYTES:end].decode("ascii"), datagram[end + 1 :]
    except UnicodeDecodeError:
        return None


def _open(url: str) -> socket.socket:
    parts = urllib.parse.urlsplit(url)
    if parts.scheme != "udpm":
        raise ValueError(f"{url}: can only listen to udpm://; read_log reads logs")
    group = parts.hostname or "239.255.76.67"
    port = parts.port or 7667
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM, socket.IPPROTO_UDP)
    try:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2 << 20)
        receiver.bind((group, port))
        wanted = struct.pack("=4sl", socket.inet_aton(group), socket.INADDR_ANY)
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, wanted)
    except OSError as error:
        receiver.close()
        sentence = f"{url}: cannot listen there: {error.strerror} (`plslam doctor` gives details)"
        raise OSError(error.errno, sentence) from error
    return receiver


class _Repeats:
    """Detects messages that were received before."""

    def __init__(self) -> None:
        self._seen: Dict[Tuple[str, int], "collections.OrderedDict[int, None]"] = {}

    def has(self, channel: str, source: int, seq: int) -> bool:
        seen = self._seen.setdefault((channel, source), collections.OrderedDict())
        if seq in seen:
            return True
        seen[seq] = None
        if len(seen) > _REMEMBERED:
            seen.popitem(last=False)
        return False


def listen(
    url: str = DEFAULT_URL,
    prefix: str = "",
    channels: Optional[Collection[str]] = None,
    timeout_s: Optional[float] = None,
) -> Iterator[Message]:
    """Yields messages as they arrive, each once, from the call on; without end.

    `prefix` is the robot's (`bus.prefix`), `channels` the requested names (all). With `timeout_s` it ends after such a
    time without messages. A listener does not take part in the repair of lost messages: it never delays a process, and
    has gaps (value.header.seq) if the network or this program is too slow. MACs are not checked.
    """
    receiver = _open(url)
    return _receive(receiver, prefix, channels, timeout_s)


def _receive(
    receiver: socket.socket, prefix: str, channels: Optional[Collection[str]], timeout_s: Optional[float]
) -> Iterator[Message]:
    repeats = _Repeats()
    with receiver:
        last = time.monotonic()
        while True:
            if timeout_s is not None:
                receiver.settimeout(max(1e-3, last + timeout_s - time.monotonic()))
            try:
                datagram = receiver.recv(_MAX_DATAGRAM)
            except socket.timeout:
                return
            channel, content = parse_datagram(datagram) or ("", b"")
            name = without_prefix(channel, prefix, channels)
            if not name:
                if timeout_s is not None and time.monotonic() > last + timeout_s:
                    return
                continue
            try:
                value = decode(content)
            except ValueError:
                continue  # Any program can send anything.
            if value is None:
                warn_of_version("the bus", name, content)
                continue
            if repeats.has(name, value.header.source, value.header.seq):
                continue
            last = time.monotonic()
            yield Message(name, time.time(), value)


def transform(pose: Any) -> np.ndarray:
    """Returns a pose3_t as a 4 x 4 matrix that transforms points from its second frame to the first."""
    return matrices(pose.position_m, pose.q_wxyz)


def matrices(position: np.ndarray, q_wxyz: np.ndarray) -> np.ndarray:
    """Returns the poses (..., 4, 4) of positions (..., 3) and unit quaternions (..., 4)."""
    position = np.asarray(position, dtype=float)
    out = np.zeros(position.shape[:-1] + (4, 4))
    out[..., :3, :3] = _rotations(q_wxyz)
    out[..., :3, 3] = position
    out[..., 3, 3] = 1.0
    return out


def _rotations(q_wxyz: np.ndarray) -> np.ndarray:
    """Returns the rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q_wxyz, dtype=float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
