# SPDX-License-Identifier: BSD-3-Clause
"""Messages: their encoding, LCM's datagrams, and the recognition of other versions."""

import warnings

import numpy as np
import plslam
import pytest
from plslam.wire import decode, parse_datagram, warn_of_version


def pose3(position_m, q_wxyz):
    pose = plslam.pose3_t()
    pose.position_m, pose.q_wxyz = position_m, q_wxyz
    return pose


def warnings_of(name, schema):
    """Returns the warnings for a message of an unknown type with this number as its schema."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_version("room.lcm", name, bytes(8) + schema.to_bytes(4, "big") + bytes(32))
    return [str(warning.message) for warning in caught]


def test_a_decoded_message_equals_the_encoded_one():
    status = plslam.status_t()
    status.process, status.header.t_ns, status.uptime_s = "vo", 1_700_000_000_123_456_789, 1.5
    decoded = decode(status.encode() + b"a MAC after it")
    assert isinstance(decoded, plslam.status_t)
    assert (decoded.process, decoded.header.t_ns, decoded.uptime_s) == ("vo", 1_700_000_000_123_456_789, 1.5)


def test_a_cut_message_is_none_or_an_error():
    data = plslam.pose_t().encode()
    for size in range(len(data)):
        if size < 8:
            assert decode(data[:size]) is None, "the type is not known before its fingerprint ends"
        else:
            with pytest.raises(ValueError, match="^not a pose_t: "):
                decode(data[:size])


def test_bytes_of_other_programs_are_none():
    assert decode(b"") is None
    assert decode(b"some other message") is None
    # The struct has no header: it is only a part of messages.
    assert decode(plslam.pose3_t().encode()) is None


@pytest.mark.parametrize(
    "datagram, parsed",
    [
        (b"LC02\0\0\0\7POSE\0ab", ("POSE", b"ab")),
        (b"LC02\0\0\0\7POSE\0", ("POSE", b"")),
        (b"LC03" + bytes(40), None),
        (b"LC02" + bytes(4) + b"POSE", None),
        (b"LC02" + bytes(4) + b"P\xffSE\0ab", None),
        (b"LC0", None),
        (b"", None),
    ],
    ids=["message", "no content", "part of a long message", "endless channel", "not ASCII", "short", "empty"],
)
def test_datagrams_of_lcm(datagram, parsed):
    assert parse_datagram(datagram) == parsed


def test_every_channel_is_known_by_its_name(expected):
    assert len(expected["channels"]) > 10
    for name in expected["channels"]:
        (sentence,) = warnings_of(name, schema=1)
        assert sentence.startswith(f"room.lcm: {name} is from another version of plslam and skipped: ")


def test_messages_of_other_programs_give_no_warning():
    assert warnings_of("POSE", schema=395_000) == [], "other programs have a POSE, too"
    assert warnings_of("POSE", schema=0) == []
    assert warnings_of("COUNTER", schema=1) == [], "a part of messages has no channel"


def test_a_transform_takes_points_to_the_first_frame():
    half = np.sqrt(0.5)
    T_w_c = plslam.transform(pose3([1, 2, 3], [half, 0, 0, half]))  # a quarter turn about z
    assert np.allclose(T_w_c @ [1, 0, 0, 1], [1, 3, 3, 1], atol=1e-15)
    assert np.allclose(T_w_c @ [0, 1, 0, 1], [0, 2, 3, 1], atol=1e-15)


def test_a_transform_of_any_quaternion_is_rigid():
    draw = np.random.default_rng(5)
    for _ in range(20):
        q_wxyz = draw.normal(size=4)
        q_wxyz /= np.linalg.norm(q_wxyz)
        T = plslam.transform(pose3(draw.normal(size=3).tolist(), q_wxyz.tolist()))
        R = T[:3, :3]
        assert np.allclose(R @ R.T, np.eye(3), atol=1e-14) and np.linalg.det(R) > 0
        assert np.allclose(R @ q_wxyz[1:], q_wxyz[1:], atol=1e-14), "the axis stays"
        assert np.isclose(np.trace(R), 4 * q_wxyz[0] ** 2 - 1), "1 + 2 cos(angle)"
