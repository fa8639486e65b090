# SPDX-License-Identifier: BSD-3-Clause
"""Maps: load_map returns what the C++ side has written, and refuses damaged files with one sentence."""

import hashlib
import random
import re

import numpy as np
import plslam
import pytest

# docs/map_files.md: magic, format and length, then the checksum of them and of the content, then the content.
FORMAT_AT, LENGTH_AT, CHECKSUM_AT, CONTENT_AT = 8, 16, 24, 56
# The content begins with the version, and the camera as a list of 48 bytes.
CAMERA_AT, CAMERA_BYTES = 8, 48
# Five numbers are between the camera and the list of sessions.
SESSIONS_AT = CAMERA_AT + 8 + CAMERA_BYTES + 5 * 8
# The images of other cameras are the last but one, with 32 bytes each; verticals are last, with 40 bytes each.
IMAGE_BYTES = 32
UP_BYTES = 40


@pytest.fixture(scope="module")
def room(written):
    return plslam.load_map(str(written / "room.plmap"))


@pytest.fixture(scope="module")
def values(expected):
    return expected["map"]


@pytest.fixture(scope="module")
def small(written):
    """The bytes of a small map."""
    return (written / "small.plmap").read_bytes()


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Loads bytes as a map in a file bad.plmap."""
    monkeypatch.chdir(tmp_path)

    def load_bytes(data):
        (tmp_path / "bad.plmap").write_bytes(data)
        return plslam.load_map("bad.plmap")

    return load_bytes


def signed(data, content):
    """The file with another content, and the right length and checksum."""
    head = data[:LENGTH_AT] + len(content).to_bytes(8, "little")
    return head + hashlib.blake2b(head + content, digest_size=32).digest() + content


def column(rows, name):
    return np.array([row[name] for row in rows])


def observations(rows):
    """The observations of all landmarks, as the package lists them: row, keyframe, feature."""
    return [(i, *observation) for i, row in enumerate(rows) for observation in row["observations"]]


def assert_columns_equal(table, rows):
    """Compares the members of a dataclass, or the fields of a structured array, with those of the written elements."""
    for name in rows[0]:
        if name == "observations":
            continue
        found, written = table[name] if isinstance(table, np.ndarray) else getattr(table, name), column(rows, name)
        assert found.shape == written.shape, name
        # A file has quaternions, and a rotation matrix is computed from them twice.
        tolerance = 1e-12 if name.startswith("T_") else 0
        assert np.abs(found - written).max() <= tolerance, name


def test_version_and_camera_equal_the_written_ones(room, values):
    assert room.version == values["version"]
    assert vars(room.camera) == values["camera"]


def test_keyframes_equal_the_written_ones(room, values):
    assert len(values["keyframes"]) > 3
    assert_columns_equal(room.keyframes, values["keyframes"])


@pytest.mark.parametrize("name", ["points", "lines"])
def test_landmarks_equal_the_written_ones(room, values, name):
    landmarks = getattr(room, name)
    assert len(values[name]) > 20
    assert_columns_equal(landmarks, values[name])
    assert landmarks.observations.tolist() == observations(values[name])


def test_features_equal_the_written_ones(room, values):
    assert sorted(room.features) == sorted(int(id) for id in values["features"]) == room.keyframes.id.tolist()
    for id, features in room.features.items():
        written = values["features"][str(id)]
        assert_columns_equal(features.points, written["points"])
        assert_columns_equal(features.lines, written["lines"])


def test_images_of_another_camera_are_read(room, values):
    images = {id: features.image for id, features in room.features.items()}
    written = {int(id): features["image"] for id, features in values["features"].items()}
    assert {id: image and list(image) for id, image in images.items()} == written
    assert None in images.values() and len(set(images.values())) > 2


def test_loops_equal_the_written_ones(room, values):
    assert len(values["loops"]) > 0
    for name in ("old_keyframe_id", "keyframe_id", "covariance", "n_points", "n_lines"):
        assert np.array_equal(room.loops[name], column(values["loops"], name)), name
    for name in ("position", "q_xyzw"):
        assert np.array_equal(room.loops["T_old_kf"][name], column(values["loops"], name)), name


def test_maps_of_releases_are_read(source):
    maps = sorted(source.glob("tests/golden/*/room.plmap"))
    assert maps
    for path in maps:
        contents = (path.parent / "contents.txt").read_text()
        keyframes, points, lines, seen, loops = map(
            int,
            re.match(
                r"map: (\d+) keyframes, (\d+) points, (\d+) lines, (\d+) observations, (\d+) loops", contents
            ).groups(),
        )
        room = plslam.load_map(str(path))
        assert (len(room.keyframes.id), len(room.points.id), len(room.lines.id)) == (keyframes, points, lines)
        assert len(room.points.observations) + len(room.lines.observations) == seen
        assert len(room.loops) == loops
        written = re.findall(r"^keyframe (\d+): (\d+) ns, at (\S+) (\S+) (\S+)$", contents, re.MULTILINE)
        assert room.keyframes.t_ns.tolist() == [int(row[1]) for row in written]
        positions = np.array([row[2:] for row in written], dtype=float)
        assert np.abs(room.keyframes.T_w_kf[:, :3, 3] - positions).max() < 1e-6


def test_a_missing_file_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        plslam.load_map(str(tmp_path / "none.plmap"))


def test_every_changed_byte_is_detected(load, small):
    assert len(load(small).keyframes.id) > 0
    for at in range(0, len(small), max(1, len(small) // 300)):
        with pytest.raises(plslam.FileError, match="^bad.plmap: "):
            load(small[:at] + bytes([small[at] ^ 1]) + small[at + 1 :])


def test_every_truncation_is_detected(load, small):
    sentence = "^bad.plmap: (is not a map file|has .* it was truncated or damaged)$"
    for size in range(0, len(small), max(1, len(small) // 100)):
        with pytest.raises(plslam.FileError, match=sentence):
            load(small[:size])


def test_a_newer_format_is_named(load, small):
    newer = small[:FORMAT_AT] + bytes([4]) + small[FORMAT_AT + 1 :]
    with pytest.raises(plslam.FileError, match="^bad.plmap: .* of format 4, but this package reads formats 1 to 3$"):
        load(newer)


def test_a_count_beyond_the_file_is_detected(load, small):
    content = small[CONTENT_AT:]
    huge = content[:SESSIONS_AT] + bytes(8 * [0x7F]) + content[SESSIONS_AT + 8 :]
    with pytest.raises(plslam.FileError, match="^bad.plmap: the content is shorter than it states$"):
        load(signed(small, huge))


def test_a_count_of_landmarks_beyond_memory_is_detected(load, small):
    room, content = load(small), small[CONTENT_AT:]
    for landmarks in (room.points, room.lines):
        count = len(landmarks.id).to_bytes(8, "little")
        sentences = set()
        # Some other number of the file may be the same.
        for found in re.finditer(re.escape(count), content, re.DOTALL):
            try:
                load(signed(small, content[: found.start()] + bytes(8 * [0x7F]) + content[found.end() :]))
            except plslam.FileError as error:
                sentences.add(str(error))
        assert sentences == {"bad.plmap: the content is shorter than it states"}


def test_bytes_after_the_content_are_detected(load, small):
    with pytest.raises(plslam.FileError, match="^bad.plmap: the content is longer than stated in its header$"):
        load(signed(small, small[CONTENT_AT:] + bytes(8)))


def test_a_map_without_camera_is_refused(load, small):
    content = small[CONTENT_AT:]
    without = content[:CAMERA_AT] + bytes(8) + content[CAMERA_AT + 8 + CAMERA_BYTES :]
    with pytest.raises(plslam.FileError, match="^bad.plmap: does not contain the camera with which it was made$"):
        load(signed(small, without))


def test_an_image_of_no_keyframe_is_refused(load, small):
    content = small[CONTENT_AT:]
    end = len(content) - 8 - UP_BYTES * int((load(small).keyframes.up_sigma_rad > 0).sum())
    at = end - IMAGE_BYTES
    foreign = content[:at] + (77).to_bytes(8, "little") + content[at + 8 :]
    with pytest.raises(plslam.FileError, match="^bad.plmap: an image belongs to keyframe 77, which has no features$"):
        load(signed(small, foreign))


def test_a_vertical_of_no_keyframe_is_refused(load, small):
    content = small[CONTENT_AT:]
    foreign = content[:-UP_BYTES] + (77).to_bytes(8, "little") + content[8 - UP_BYTES :]
    with pytest.raises(plslam.FileError, match="^bad.plmap: there is a vertical for a keyframe that does not exist$"):
        load(signed(small, foreign))


def test_random_content_loads_or_raises_one_sentence(load, small):
    """Any value may be invalid in a file with a right checksum: nothing but FileError is raised."""
    content = small[CONTENT_AT:]
    draw = random.Random(1)
    loaded = 0
    for _ in range(400):
        at = draw.randrange(len(content) // 8) * 8
        try:
            load(signed(small, content[:at] + draw.randbytes(8) + content[at + 8 :]))
            loaded += 1
        except plslam.FileError as error:
            assert re.match("^bad.plmap: [^\n]+$", str(error))
    assert 0 < loaded < 400, "positions may be any numbers, and counts may not"
