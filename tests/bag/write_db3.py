#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""write_db3.py FILE.mcap FOLDER [split] [zstd-files] [zstd-messages]: converts an MCAP file without chunks into a bag of
ROS 2 as rosbag2 writes it with SQLite (tables, index, metadata.yaml; zstd compresses by the program of that name)."""
import pathlib
import sqlite3
import struct
import subprocess
import sys

SCHEMA = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


def zstd(data):
    return subprocess.run(["zstd", "-q", "-c"], input=data, stdout=subprocess.PIPE, check=True).stdout


def text_at(record, at):
    (n,) = struct.unpack_from("<I", record, at)
    return record[at + 4 : at + 4 + n].decode(), at + 4 + n


def read_mcap(path):
    """Returns the channels, by id (topic, type, encoding), and the messages: channel, log time, content."""
    data = path.read_bytes()
    schemas, channels, messages, at = {}, {}, [], 8
    while at < len(data) - 8:
        kind, n = struct.unpack_from("<BQ", data, at)
        record = data[at + 9 : at + 9 + n]
        at += 9 + n
        if kind == 0x03:
            schemas[struct.unpack_from("<H", record)[0]] = text_at(record, 2)[0]
        elif kind == 0x04:
            channel, schema = struct.unpack_from("<HH", record)
            topic, after = text_at(record, 4)
            channels[channel] = (topic, schemas[schema], text_at(record, after)[0])
        elif kind == 0x05:
            channel, _, log_ns = struct.unpack_from("<HIQ", record)
            messages.append((channel, log_ns, record[22:]))
    return channels, messages


def main():
    folder, options = pathlib.Path(sys.argv[2]), sys.argv[3:]
    channels, messages = read_mcap(pathlib.Path(sys.argv[1]))
    folder.mkdir(parents=True)
    parts = 12 if "split" in options else 1
    names = []
    for part in range(parts):
        file = folder / f"{folder.name}_{part}.db3"
        with sqlite3.connect(file) as database:
            database.executescript(SCHEMA)
            database.executemany(
                "INSERT INTO topics VALUES(?, ?, ?, ?, '', '')", [(i + 1, *channel) for i, channel in channels.items()]
            )
            for channel, log_ns, content in messages[part * len(messages) // parts : (part + 1) * len(messages) // parts]:
                database.execute(
                    "INSERT INTO messages(timestamp, topic_id, data) VALUES(?, ?, ?)",
                    (log_ns, channel + 1, zstd(content) if "zstd-messages" in options else content),
                )
        database.close()
        if "zstd-files" in options:
            file.with_name(file.name + ".zstd").write_bytes(zstd(file.read_bytes()))
            file.unlink()
            file = file.with_name(file.name + ".zstd")
        names.append(file.name)
    mode = "FILE" if "zstd-files" in options else "MESSAGE" if "zstd-messages" in options else ""
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  relative_file_paths:\n"
        + "".join(f"    - {name}\n" for name in names)
        + f'  message_count: {len(messages)}\n  compression_format: "{"zstd" if mode else ""}"\n  compression_mode: "{mode}"\n'
    )


if __name__ == "__main__":
    main()
