# SPDX-License-Identifier: BSD-3-Clause
"""Stereo odometry in this process, by the shared library libplslam_odometry (ctypes)."""

import ctypes
import ctypes.util
import functools
import os
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

STATES = ("initialising", "tracking", "weak", "lost", "recovered")


class _Image(ctypes.Structure):
    _fields_ = [
        ("pixels", ctypes.c_void_p),
        ("row_bytes", ctypes.c_int64),
        ("width_px", ctypes.c_int32),
        ("height_px", ctypes.c_int32),
        ("bits", ctypes.c_int32),
    ]


class _Pose(ctypes.Structure):
    _fields_ = [
        ("t_ns", ctypes.c_int64),
        ("state", ctypes.c_int32),
        ("is_keyframe", ctypes.c_int32),
        ("tracked_points", ctypes.c_int32),
        ("tracked_lines", ctypes.c_int32),
        ("T_odom_c", ctypes.c_double * 16),
        ("covariance", ctypes.c_double * 36),
        ("T_prev_c", ctypes.c_double * 16),
        ("motion_covariance", ctypes.c_double * 36),
    ]


@dataclass
class TrackedPose:
    """Pose of a frame. odom is the first camera, c the rectified left camera, prev that of the previous frame."""

    t_ns: int
    state: str  # one of STATES; the pose of a lost frame is a prediction
    is_keyframe: bool
    tracked_points: int
    tracked_lines: int
    T_odom_c: np.ndarray  # 4 x 4
    covariance: np.ndarray  # 6 x 6: translation in m, rotation in rad, of the right perturbation
    T_prev_c: np.ndarray
    motion_covariance: np.ndarray


@functools.lru_cache(maxsize=None)
def _load() -> ctypes.CDLL:
    here = os.path.dirname(os.path.abspath(__file__))
    name = "libplslam_odometry.so"
    # In a build folder, in an installed tree, and where the system has its libraries.
    candidates = [os.path.join(here, "..", "..", "lib", name), os.path.join(here, "..", "..", "..", "plslam", name)]
    path = next((p for p in candidates if os.path.exists(p)), None) or ctypes.util.find_library("plslam_odometry")
    if path is None:
        raise OSError(f"{name} is missing: install the package plslam, or build the target plslam_odometry")
    library = ctypes.CDLL(path)
    library.plslam_odometry_create.restype = ctypes.c_void_p
    library.plslam_odometry_create.argtypes = [
        ctypes.c_char_p,
        ctypes.c_int32,
        ctypes.c_int32,
        ctypes.c_char_p,
        ctypes.c_char_p,
        ctypes.c_size_t,
    ]
    library.plslam_odometry_destroy.restype = None
    library.plslam_odometry_destroy.argtypes = [ctypes.c_void_p]
    library.plslam_odometry_track.argtypes = [
        ctypes.c_void_p,
        ctypes.c_int64,
        ctypes.POINTER(_Image),
        ctypes.POINTER(_Image),
        ctypes.POINTER(_Pose),
    ]
    library.plslam_odometry_record.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
    library.plslam_odometry_error.restype = ctypes.c_char_p
    library.plslam_odometry_error.argtypes = [ctypes.c_void_p]
    return library


class Odometry:
    """Stereo odometry with points and lines: pairs in, poses out, without other processes.

        odometry = plslam.Odometry("camera.yaml")
        pose = odometry.track(left, right, t_ns)   # grey images as recorded; a depth map of 16 bits on the right

    `calibration`: camera.yaml, or a file of another program; `size`: (width, height) of the images if it does not state
    them; `options`: section vo of a configuration, as text. Errors are ValueError with one sentence.
    """

    def __init__(self, calibration: str, options: Optional[str] = None, size: Tuple[int, int] = (0, 0)) -> None:
        self._library = _load()
        error = ctypes.create_string_buffer(1024)
        self._handle = self._library.plslam_odometry_create(
            os.fsencode(calibration), size[0], size[1], options.encode() if options else None, error, len(error)
        )
        if not self._handle:
            raise ValueError(error.value.decode(errors="replace"))

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self._library.plslam_odometry_destroy(self._handle)

    def record(self, folder: Optional[str]) -> None:
        """Writes the following pairs into a new folder, a dataset that reproduces the run; None ends it."""
        self._check(self._library.plslam_odometry_record(self._handle, os.fsencode(folder) if folder else None))

    def track(self, left: np.ndarray, right: np.ndarray, t_ns: int) -> TrackedPose:
        """Tracks the next pair, exposed at `t_ns`, later than the previous one."""
        # The arrays live until the call returns.
        left, right = np.ascontiguousarray(left), np.ascontiguousarray(right)
        pose = _Pose()
        self._check(
            self._library.plslam_odometry_track(
                self._handle,
                int(t_ns),
                ctypes.byref(self._image(left)),
                ctypes.byref(self._image(right)),
                ctypes.byref(pose),
            )
        )
        return TrackedPose(
            pose.t_ns,
            STATES[pose.state],
            bool(pose.is_keyframe),
            pose.tracked_points,
            pose.tracked_lines,
            np.array(pose.T_odom_c).reshape(4, 4),
            np.array(pose.covariance).reshape(6, 6),
            np.array(pose.T_prev_c).reshape(4, 4),
            np.array(pose.motion_covariance).reshape(6, 6),
        )

    @staticmethod
    def _image(array: np.ndarray) -> _Image:
        if array.ndim != 2 or array.dtype not in (np.uint8, np.uint16):
            raise ValueError(
                f"an image is an array of rows and columns of uint8 (depths: uint16), not {array.ndim} dimensions of "
                f"{array.dtype}"
            )
        height, width = array.shape
        return _Image(array.ctypes.data, array.strides[0], width, height, 8 * array.itemsize)

    def _check(self, code: int) -> None:
        if code != 0:
            raise ValueError(self._library.plslam_odometry_error(self._handle).decode(errors="replace"))
