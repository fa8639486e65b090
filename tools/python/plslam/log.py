# SPDX-License-Identifier: BSD-3-Clause
"""LCM logs, as `plslam record`, `plslam run --record` and lcm-logger write them."""

import os
import struct
from typing import BinaryIO, Collection, Iterator, Optional

from .errors import FileError
from .wire import Message, decode, warn_of_version, without_prefix

_SYNC = 0xEDA1DA01
_EVENT = struct.Struct(">IqqII")
_MAX_CHANNEL = 63


def read_log(path: str, prefix: str = "", channels: Optional[Collection[str]] = None) -> Iterator[Message]:
    """Messages of a log, in its order. Those of other programs are passed over; so are those of another version of
    plslam, with a warning for each channel.

    Raises FileError, which names the file and the byte, where it is no log, damaged or cut off; what stands before
    that place has been given by then. Raises OSError where it cannot be opened.
    """
    file = open(path, "rb")  # Here and not in the generator: a file that is not there is told at once.
    size = os.path.getsize(path)
    return _read(file, size, path, prefix, channels)


def _read(
    file: BinaryIO, size: int, path: str, prefix: str, channels: Optional[Collection[str]]
) -> Iterator[Message]:
    with file:
        if size == 0:
            raise FileError(f"{path}: is empty")
        offset = 0
        while offset < size:
            head = file.read(_EVENT.size)
            if len(head) < _EVENT.size and (offset > 0 or _SYNC.to_bytes(4, "big").startswith(head[:4])):
                raise FileError(f"{path}: is cut off at byte {offset}")
            sync, _, time_us, name_bytes, data_bytes = _EVENT.unpack(head.ljust(_EVENT.size, b"\0"))
            if sync != _SYNC or not 0 < name_bytes <= _MAX_CHANNEL:
                what = "is damaged" if offset > 0 else "is no LCM log"
                raise FileError(f"{path}: {what}: no event begins at byte {offset}")
            end = offset + _EVENT.size + name_bytes + data_bytes
            if end > size:
                raise FileError(f"{path}: is cut off within the event at byte {offset}")
            channel = file.read(name_bytes).decode("latin-1")
            name = without_prefix(channel, prefix, channels)
            if name is None:
                file.seek(end)
            else:
                try:
                    data = file.read(data_bytes)
                    value = decode(data)
                except ValueError as error:
                    raise FileError(f"{path}: the event at byte {offset}, channel {channel}, is {error}") from error
                if value is None:
                    warn_of_version(path, name, data)
                else:
                    yield Message(name, time_us * 1e-6, value)
            offset = end
