# SPDX-License-Identifier: BSD-3-Clause
"""LCM logs written by `plslam record`, `plslam run --record` or lcm-logger."""

import os
import struct
from typing import BinaryIO, Collection, Iterator, Optional

from .errors import FileError
from .wire import Message, decode, warn_of_version, without_prefix

_SYNC = 0xEDA1DA01
_EVENT = struct.Struct(">IqqII")
_MAX_CHANNEL = 63


def read_log(path: str, prefix: str = "", channels: Optional[Collection[str]] = None) -> Iterator[Message]:
    """Yields the messages of a log, in its order. Messages of other programs are skipped, and so are those from another
    version of plslam, with a warning for each channel.

    Raises FileError, which names the file and the byte, if it is not a log, damaged or truncated; messages before that
    position have been yielded by then. Raises OSError if it cannot be opened.
    """
    file = open(path, "rb")  # Here and not in the generator: a missing file is reported at once.
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
                raise FileError(f"{path}: is truncated at byte {offset}")
            sync, _, time_us, name_bytes, data_bytes = _EVENT.unpack(head.ljust(_EVENT.size, b"\0"))
            if sync != _SYNC or not 0 < name_bytes <= _MAX_CHANNEL:
                what = "is damaged" if offset > 0 else "is not an LCM log"
                raise FileError(f"{path}: {what}: no event begins at byte {offset}")
            end = offset + _EVENT.size + name_bytes + data_bytes
            if end > size:
                raise FileError(f"{path}: is truncated within the event at byte {offset}")
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
