# SPDX-License-Identifier: BSD-3-Clause
"""Logs: read_log yields the recorded messages, up to damage, which it names."""

import collections
import time
import warnings

import plslam
import pytest

SYNC = b"\xed\xa1\xda\x01"  # begins each event


@pytest.fixture
def log(written, tmp_path, monkeypatch):
    """The bytes of a log of 20 poses and a status, with the prefix front/; the test runs in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return (written / "front.lcm").read_bytes()


@pytest.fixture
def read(tmp_path):
    """Writes bytes to a file bad.lcm; returns the number of messages before its damage, and the sentence."""

    def read_bytes(data):
        (tmp_path / "bad.lcm").write_bytes(data)
        count = 0
        with pytest.raises(plslam.FileError) as error:
            for _ in plslam.read_log("bad.lcm", prefix="front/"):
                count += 1
        return count, str(error.value)

    return read_bytes


def test_messages_equal_the_written_ones(written, expected):
    messages = list(plslam.read_log(str(written / "front.lcm"), prefix="front/"))
    poses, status = messages[:-1], messages[-1]
    assert len(poses) == 20 and {message.channel for message in poses} == {"POSE"}
    found = [
        {
            "frame_id": pose.value.frame_id,
            "t_ns": pose.value.header.t_ns,
            "z_m": plslam.transform(pose.value.T_odom_c)[2, 3],
            "stage": pose.value.stages[0].name,
        }
        for pose in poses
    ]
    assert found == expected["log"]
    assert (status.channel, status.value.process, status.value.state) == ("STATUS", "vo", "running")


def test_times_ascend_and_are_seconds_since_1970(written):
    times = [message.time_s for message in plslam.read_log(str(written / "run.lcm"))]
    assert times == sorted(times)
    # The log was written a moment ago.
    assert abs(times[-1] - time.time()) < 3600


def test_a_prefix_selects_a_robot(written):
    front, plain = str(written / "front.lcm"), str(written / "run.lcm")
    assert list(plslam.read_log(front, prefix="rear/")) == []
    assert list(plslam.read_log(front)) == []
    assert len(list(plslam.read_log(plain))) == 21
    assert list(plslam.read_log(plain, prefix="front/")) == []


def test_channels_are_selected_by_name(written):
    front = str(written / "front.lcm")
    messages = list(plslam.read_log(front, prefix="front/", channels=["STATUS", "KEYFRAME"]))
    assert [message.channel for message in messages] == ["STATUS"]


def test_a_missing_log_is_an_error_at_once():
    with pytest.raises(FileNotFoundError):
        plslam.read_log("none.lcm")


def test_a_truncated_log_is_read_up_to_its_last_event(log, read):
    last = log.rfind(SYNC)
    assert read(log[:-10]) == (20, f"bad.lcm: is truncated within the event at byte {last}")
    assert read(log[: last + 5]) == (20, f"bad.lcm: is truncated at byte {last}")


def test_a_damaged_log_is_read_up_to_its_damage(log, read):
    middle = log.find(SYNC, len(log) // 2)
    count, sentence = read(log[:middle] + b"xx" + log[middle:])
    assert 5 < count < 20
    assert sentence == f"bad.lcm: is damaged: no event begins at byte {middle}"


def test_a_damaged_message_is_named_with_its_channel(log, read):
    # An event with the first bytes of a pose: its fingerprint is valid, its length is not.
    name = b"front/POSE"
    body = log.find(name) + len(name)
    event = SYNC + bytes(16) + len(name).to_bytes(4, "big") + (20).to_bytes(4, "big") + name + log[body : body + 20]
    count, sentence = read(log + event)
    assert count == 21
    assert sentence.startswith(f"bad.lcm: the event at byte {len(log)}, channel front/POSE, is not a pose_t: ")


@pytest.mark.parametrize(
    "data, sentence",
    [
        (b"", "is empty"),
        (b"hello\n", "is not an LCM log: no event begins at byte 0"),
        (SYNC + b"\0\0", "is truncated at byte 0"),
        (SYNC[:3] + b"\2" + bytes(60), "is not an LCM log: no event begins at byte 0"),
        (SYNC + bytes(60), "is not an LCM log: no event begins at byte 0"),
    ],
    ids=["empty", "text", "head", "other magic number", "event without channel"],
)
def test_other_files_are_no_logs(log, read, data, sentence):
    assert read(data) == (0, f"bad.lcm: {sentence}")


def test_messages_of_another_version_give_one_warning(source):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        counts = collections.Counter(
            message.channel for message in plslam.read_log(str(source / "tests/golden/0.2/room.lcm"))
        )
    assert counts["STEREO_FRAME"] > 10
    assert "MAP_UPDATE" not in counts
    sentences = [str(warning.message) for warning in caught]
    assert sum("MAP_UPDATE is from another version" in sentence for sentence in sentences) == 1, sentences
