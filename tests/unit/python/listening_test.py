# SPDX-License-Identifier: BSD-3-Clause
"""Live messages: listen yields each message of a robot once, and nothing of other programs."""

import itertools
import socket
import urllib.parse

import plslam
import pytest

PATIENCE_S = 60


@pytest.fixture
def send(url):
    """Sends a message as a datagram of LCM to the URL of the test."""
    to = urllib.parse.urlsplit(url)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)

        def send_bytes(channel, content):
            sender.sendto(b"LC02" + bytes(4) + channel.encode() + b"\0" + content, (to.hostname, to.port))

        yield send_bytes


def pose(seq, source=1):
    message = plslam.pose_t()
    message.header.seq, message.header.source, message.header.schema = seq, source, 1
    return message.encode()


def first(n, messages):
    """The numbers of the first messages."""
    return [message.value.header.seq for message in itertools.islice(messages, n)]


def test_messages_of_a_process_arrive_once_in_order(url, publisher, expected):
    publisher(prefix="front/")
    messages = plslam.listen(url, prefix="front/", channels=["POSE"], timeout_s=PATIENCE_S)
    poses = [message.value for message in itertools.islice(messages, 50)]
    frames = [pose.frame_id for pose in poses]
    assert len(frames) == 50
    assert frames == sorted(set(frames)), "from any number on, as the listener began later"
    assert [pose.header.seq for pose in poses] == frames
    begin_ns = expected["log"][0]["t_ns"]
    assert [pose.header.t_ns for pose in poses] == [begin_ns + frame for frame in frames]
    assert poses[-1].T_odom_c.position_m[2] == 0.25 * frames[-1]


def test_nothing_is_heard_of_another_robot(url, publisher):
    publisher(prefix="front/")
    assert first(1, plslam.listen(url, prefix="front/", channels=["POSE"], timeout_s=PATIENCE_S)), "it publishes"
    assert list(plslam.listen(url, prefix="rear/", timeout_s=0.2)) == []
    assert list(plslam.listen(url, timeout_s=0.2)) == []


def test_messages_are_kept_from_the_call_on(url, send):
    messages = plslam.listen(url, timeout_s=PATIENCE_S)
    send("POSE", pose(seq=0))
    assert first(1, messages) == [0]


def test_a_resent_message_is_yielded_once(url, send):
    messages = plslam.listen(url, timeout_s=PATIENCE_S)
    for seq in (0, 0, 1, 0, 2):
        send("POSE", pose(seq))
    assert first(3, messages) == [0, 1, 2]


def test_publishers_and_channels_have_own_numbers(url, send):
    messages = plslam.listen(url, timeout_s=PATIENCE_S)
    send("POSE", pose(seq=0, source=1))
    send("POSE", pose(seq=0, source=2))
    send("POSE_OF_OTHERS", pose(seq=0, source=1))
    send("POSE", pose(seq=1, source=1))
    assert first(4, messages) == [0, 0, 0, 1]


def test_channels_and_prefix_select_messages(url, send):
    messages = plslam.listen(url, prefix="front/", channels=["POSE"], timeout_s=PATIENCE_S)
    for seq, channel in enumerate(["POSE", "front/STATUS", "rear/POSE", "front/left/POSE", "front/POSE"]):
        send(channel, pose(seq))
    assert [(m.channel, m.value.header.seq) for m in itertools.islice(messages, 1)] == [("POSE", 4)]


def test_bytes_of_other_programs_are_skipped(url, send):
    messages = plslam.listen(url, timeout_s=PATIENCE_S)
    send("POSE", b"")
    send("POSE", b"hello, hello, hello")
    send("POSE", pose(seq=0)[:100])
    send("POSE", pose(seq=1) + b"a MAC after it")
    assert first(1, messages) == [1]


def test_a_message_of_another_version_gives_a_warning(url, send):
    messages = plslam.listen(url, timeout_s=PATIENCE_S)
    other = bytes(8) + pose(seq=0)[8:]
    send("POSE", other)
    send("POSE", pose(seq=1))
    with pytest.warns(UserWarning, match="^the bus: POSE is from another version of plslam and skipped: "):
        assert first(1, messages) == [1]


def test_silence_ends_a_listener_with_a_limit(url, send):
    messages = plslam.listen(url, timeout_s=0.2)
    send("OTHER", b"not ours")
    assert list(messages) == []


def test_other_urls_are_refused():
    with pytest.raises(ValueError, match="^tcpq://localhost:7700: can only listen to udpm://; read_log reads logs$"):
        plslam.listen("tcpq://localhost:7700")
