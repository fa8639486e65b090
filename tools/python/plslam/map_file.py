# SPDX-License-Identifier: BSD-3-Clause
"""Map files (.plmap) as arrays. docs/map_files.md describes the format."""

import hashlib
import struct
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

import numpy as np

from .errors import FileError
from .wire import matrices

_MAGIC = b"PLSLAMAP"
_FORMATS = (1, 2, 3)
_SEAL = struct.Struct("<8sQQ32s")
_SUMMED = 24

_POSE = [("position", "<f8", 3), ("q_xyzw", "<f8", 4)]
_KEYFRAME = np.dtype(
    [("id", "<i8"), ("session", "<i8"), ("session_keyframe_id", "<i8"), ("frame_id", "<i8"), ("t_ns", "<i8")]
    + [("T_w_kf", _POSE), ("covariance", "<f8", (6, 6)), ("T_odom_kf", _POSE), ("previous_id", "<i8")]
    + [("T_prevkf_kf", _POSE), ("relative_covariance", "<f8", (6, 6)), ("parent_id", "<i8")]
)
_POINT_FEATURE = np.dtype(
    [("px", "<f8", 2), ("response", "<f4"), ("angle_rad", "<f4"), ("octave", "<i4"), ("descriptor", "u1", 32)]
    + [("scale", "<f8"), ("disparity_px", "<f8"), ("sigma_px", "<f8"), ("sigma_disparity_px", "<f8")]
)
_LINE_FEATURE = np.dtype(
    [("p_px", "<f8", 2), ("q_px", "<f8", 2), ("response", "<f4"), ("octave", "<i4"), ("descriptor", "u1", 32)]
    + [("disparity_p_px", "<f8"), ("disparity_q_px", "<f8"), ("sigma_px", "<f8")]
    + [("sigma_disparity_p_px", "<f8"), ("sigma_disparity_q_px", "<f8")]
)
_POINT = np.dtype(
    [("id", "<i8"), ("p_w", "<f8", 3), ("covariance", "<f8", (3, 3)), ("descriptor", "u1", 32)]
    + [("angle_rad", "<f4"), ("octave", "<i4"), ("depth_m", "<f8")]
)
_LINE = np.dtype(
    [("id", "<i8"), ("p_w", "<f8", 3), ("q_w", "<f8", 3), ("covariance_p", "<f8", (3, 3))]
    + [("covariance_q", "<f8", (3, 3)), ("descriptor", "u1", 32)]
)
_OBSERVATION = np.dtype([("keyframe_id", "<i8"), ("feature", "<i4")])
_LOOP = np.dtype(
    [("old_keyframe_id", "<i8"), ("keyframe_id", "<i8"), ("T_old_kf", _POSE), ("covariance", "<f8", (6, 6))]
    + [("n_points", "<i4"), ("n_lines", "<i4")]
)


# Images of keyframes taken by a camera other than that of the map.
_IMAGE = np.dtype(
    [("keyframe_id", "<i8"), ("left_px", "<i4"), ("top_px", "<i4"), ("width_px", "<i4"), ("height_px", "<i4")]
    + [("f_px", "<f8")]
)


# The vertical that an inertial sensor measured from a keyframe.
_UP = np.dtype([("keyframe_id", "<i8"), ("up_c", "<f8", 3), ("sigma_rad", "<f8")])


@dataclass
class Camera:
    """The rectified pair: f in pixels, principal point, baseline, image size."""

    f_px: float
    cx_px: float
    cy_px: float
    baseline_m: float
    width_px: int
    height_px: int


@dataclass
class Keyframes:
    """Row i of each array is one keyframe; ids ascend. Covariances are of right perturbations [translation; rotation]."""

    id: np.ndarray
    session: np.ndarray
    session_keyframe_id: np.ndarray
    frame_id: np.ndarray
    t_ns: np.ndarray
    T_w_kf: np.ndarray  # (n, 4, 4)
    covariance: np.ndarray  # (n, 6, 6)
    T_odom_kf: np.ndarray  # (n, 4, 4)
    previous_id: np.ndarray  # -1: none
    T_prevkf_kf: np.ndarray  # (n, 4, 4)
    relative_covariance: np.ndarray  # (n, 6, 6)
    parent_id: np.ndarray  # in the spanning tree; -1: none
    up_c: np.ndarray  # (n, 3), against gravity, seen from the keyframe; zeros: not measured
    up_sigma_rad: np.ndarray  # 0: not measured


@dataclass
class Points:
    """Points of the map. `observations` has a row for each observation in a keyframe: row, keyframe_id, feature.

    `row` is the row of the point in the other arrays, `feature` that of Features.points of the keyframe.
    """

    id: np.ndarray
    p_w: np.ndarray  # (n, 3)
    covariance: np.ndarray  # (n, 3, 3)
    descriptor: np.ndarray  # (n, 32), bytes
    octave: np.ndarray
    depth_m: np.ndarray
    observations: np.ndarray


@dataclass
class Lines:
    """Line segments of the map, by their two ends. `observations` as for points."""

    id: np.ndarray
    p_w: np.ndarray  # (n, 3)
    q_w: np.ndarray  # (n, 3)
    covariance_p: np.ndarray  # (n, 3, 3)
    covariance_q: np.ndarray  # (n, 3, 3)
    descriptor: np.ndarray  # (n, 32), bytes
    observations: np.ndarray


@dataclass
class Features:
    """Features of a keyframe as structured arrays: px, disparity_px (below 0: no depth), sigma_px, descriptor, ..."""

    points: np.ndarray
    lines: np.ndarray
    # Left, top, width and height of the image in the image plane of the map's camera, and the focal length of the
    # camera that took it, if it was another one.
    image: Optional[Tuple[int, int, int, int, float]] = None


@dataclass
class Map:
    version: int
    camera: Camera
    keyframes: Keyframes
    points: Points
    lines: Lines
    features: Dict[int, Features]  # by id of the keyframe
    loops: np.ndarray  # old_keyframe_id, keyframe_id, T_old_kf (position, q_xyzw), covariance, n_points, n_lines


def load_map(path: str) -> Map:
    """Reads a map file. Raises FileError, which names the file, if it is damaged, truncated or of another format."""
    with open(path, "rb") as file:
        data = file.read()
    try:
        version, content = _check(data)
        return _read_map(version, _Content(content))
    except FileError as error:
        raise FileError(f"{path}: {error}") from None


def _check(data: bytes) -> Tuple[int, memoryview]:
    """Returns format and content of a valid file."""
    if len(data) < _SEAL.size or data[:8] != _MAGIC:
        raise FileError("is not a map file")
    _, version, length, checksum = _SEAL.unpack_from(data)
    if version not in _FORMATS:
        formats = f"formats {_FORMATS[0]} to {_FORMATS[-1]}"
        raise FileError(f"is a map file of format {version}, but this package reads {formats}")
    if length != len(data) - _SEAL.size:
        found = len(data) - _SEAL.size
        raise FileError(f"has {found} bytes of content instead of {length}: it was truncated or damaged")
    content = memoryview(data)[_SEAL.size :]
    digest = hashlib.blake2b(data[:_SUMMED], digest_size=32)
    digest.update(content)
    if digest.digest() != checksum:
        raise FileError("is damaged: its checksum is wrong")
    return version, content


class _Content:
    """Reads values from bytes, one after the other."""

    def __init__(self, data: memoryview) -> None:
        self._data = data
        self._offset = 0

    def int64(self) -> int:
        return int(self.array(np.dtype("<i8"), 1)[0])

    def array(self, dtype: np.dtype, n: int) -> np.ndarray:
        end = self._offset + n * dtype.itemsize
        if n < 0 or end > len(self._data):
            raise FileError("the content is shorter than it states")
        values = np.frombuffer(self._data, dtype, n, self._offset)
        self._offset = end
        return values

    def list(self, dtype: np.dtype) -> np.ndarray:
        return self.array(dtype, self.int64())

    def landmarks(self, dtype: np.dtype) -> Tuple[np.ndarray, np.ndarray]:
        """Reads landmarks and their observations with the row of the landmark; each landmark precedes its own."""
        n = self.int64()
        if n < 0 or n * dtype.itemsize > len(self._data):
            raise FileError("the content is shorter than it states")
        rows = np.empty(n, dtype)
        observations: List[np.ndarray] = []
        for i in range(n):
            rows[i] = self.array(dtype, 1)[0]
            observations.append(self.list(_OBSERVATION))
        counts = [len(part) for part in observations]
        flat = np.concatenate(observations) if observations else np.empty(0, _OBSERVATION)
        out = np.empty(len(flat), [("row", "<i8"), ("keyframe_id", "<i8"), ("feature", "<i4")])
        out["row"] = np.repeat(np.arange(n), counts)
        out["keyframe_id"] = flat["keyframe_id"]
        out["feature"] = flat["feature"]
        return rows, out

    def end(self) -> None:
        if self._offset != len(self._data):
            raise FileError("the content is longer than stated in its header")


def _matrices(poses: np.ndarray) -> np.ndarray:
    return matrices(poses["position"], poses["q_xyzw"][:, [3, 0, 1, 2]])


def _read_camera(content: _Content) -> Camera:
    rig = content.list(np.dtype("u1"))
    if len(rig) != 48:
        raise FileError("does not contain the camera with which it was made")
    f, cx, cy, baseline, width, height = np.frombuffer(rig.tobytes(), "<f8")
    return Camera(float(f), float(cx), float(cy), float(baseline), int(width), int(height))


def _read_keyframes(content: _Content) -> Keyframes:
    rows = content.list(_KEYFRAME)
    poses = ("T_w_kf", "T_odom_kf", "T_prevkf_kf")
    columns = {name: _matrices(rows[name]) if name in poses else rows[name] for name in _KEYFRAME.names or ()}
    return Keyframes(**columns, up_c=np.zeros((len(rows), 3)), up_sigma_rad=np.zeros(len(rows)))


def _read_map(file_format: int, content: _Content) -> Map:
    version = content.int64()
    camera = _read_camera(content)
    content.array(np.dtype("<i8"), 5)  # Next ids, newest session and its time: for continuing the map.
    content.list(np.dtype("<i8, <i8, <i8"))  # The newest keyframe of each session, likewise.
    keyframes = _read_keyframes(content)
    features = {}
    for _ in range(content.int64()):
        keyframe_id = content.int64()
        features[keyframe_id] = Features(content.list(_POINT_FEATURE), content.list(_LINE_FEATURE))
    p, of_points = content.landmarks(_POINT)
    points = Points(p["id"], p["p_w"], p["covariance"], p["descriptor"], p["octave"], p["depth_m"], of_points)
    s, of_lines = content.landmarks(_LINE)
    lines = Lines(s["id"], s["p_w"], s["q_w"], s["covariance_p"], s["covariance_q"], s["descriptor"], of_lines)
    loops = content.list(_LOOP)
    if file_format > 1:
        for keyframe_id, left, top, width, height, f in content.list(_IMAGE).tolist():
            if keyframe_id not in features:
                raise FileError(f"an image belongs to keyframe {keyframe_id}, which has no features")
            features[keyframe_id].image = (left, top, width, height, f)
    if file_format > 2:
        ups = content.list(_UP)
        if not np.isin(ups["keyframe_id"], keyframes.id).all():
            raise FileError("there is a vertical for a keyframe that does not exist")
        rows_of_ups = np.searchsorted(keyframes.id, ups["keyframe_id"])
        keyframes.up_c[rows_of_ups] = ups["up_c"]
        keyframes.up_sigma_rad[rows_of_ups] = ups["sigma_rad"]
    content.end()
    return Map(version, camera, keyframes, points, lines, features, loops)
