# SPDX-License-Identifier: BSD-3-Clause
"""The folder of a run as arrays. docs/viewer.md describes its files."""

import csv
import decimal
import json
import pathlib
from dataclasses import dataclass
from typing import Any, Callable, Dict, Optional, Tuple

import numpy as np

from .errors import FileError
from .map_file import Map, load_map
from .wire import matrices

_MAX_TIME_S = 2**63 // 1_000_000_000


@dataclass
class Trajectory:
    """Poses with times, T_w_l of the left camera as calibrated: row i of each array is one pose."""

    t_ns: np.ndarray  # int64
    position_m: np.ndarray  # (n, 3)
    q_wxyz: np.ndarray  # (n, 4)

    def __len__(self) -> int:
        return len(self.t_ns)

    def matrices(self) -> np.ndarray:
        """(n, 4, 4)"""
        return matrices(self.position_m, self.q_wxyz)


@dataclass
class Run:
    """The outputs of a run. Missing ones are None."""

    summary: Optional[Dict[str, Any]]  # summary.json
    trajectory: Optional[Trajectory]  # in the final map
    live: Optional[Trajectory]  # as published
    keyframes: Optional[Trajectory]
    truth: Optional[Trajectory]
    covariance: Optional[Tuple[np.ndarray, np.ndarray]]  # t_ns, (n, 6, 6) of `trajectory`
    motion_covariance: Optional[Tuple[np.ndarray, np.ndarray]]
    frames: Optional[Dict[str, np.ndarray]]  # columns of poses.csv: every frame, also lost ones
    map: Optional[Map]


def load_run(folder: str) -> Run:
    """Reads the folder of a run. Raises FileError, which names file and line, if files are damaged or the
    folder has no file of a run; OSError if files cannot be opened."""
    path = pathlib.Path(folder)
    if not path.is_dir():
        raise FileError(f"{folder}: is not a folder")

    def read(name: str, reader: Callable[[str], Any]) -> Any:
        file = path / name
        return reader(str(file)) if file.exists() else None

    maps = sorted(path.glob("*.plmap"))
    run = Run(
        summary=read("summary.json", _read_json),
        trajectory=read("trajectory.tum", read_trajectory),
        live=read("trajectory_live.tum", read_trajectory),
        keyframes=read("keyframes.tum", read_trajectory),
        truth=read("groundtruth.tum", read_trajectory),
        covariance=read("covariance.txt", read_covariances),
        motion_covariance=read("motion_covariance.txt", read_covariances),
        frames=read("poses.csv", _read_table),
        map=load_map(str(maps[0])) if len(maps) == 1 else None,
    )
    if all(value is None for value in vars(run).values()):
        raise FileError(f"{folder}: has no file of a run: `plslam run --out {folder}` writes them")
    return run


def _nanoseconds(text: str) -> int:
    # A double has too few digits for nanoseconds since 1970.
    time_s = decimal.Decimal(text)
    if not abs(time_s) < _MAX_TIME_S:
        raise ValueError(f"the time {text} s is beyond {_MAX_TIME_S} s, too large for nanoseconds")
    return int((time_s * 1_000_000_000).to_integral_value())


def _rows(path: str, columns: int) -> Tuple[np.ndarray, np.ndarray]:
    """Reads times and numbers from a file of rows `t a b c ...`."""
    times, numbers = [], []
    with open(path, encoding="ascii", errors="replace") as file:
        for number, line in enumerate(file, 1):
            parts = line.split()
            if not parts or parts[0].startswith("#"):
                continue
            try:
                if len(parts) != columns:
                    raise ValueError(f"{len(parts)} numbers instead of {columns}")
                times.append(_nanoseconds(parts[0]))
                numbers.append([float(part) for part in parts[1:]])
                if not np.isfinite(numbers[-1]).all():
                    raise ValueError("a number that is not finite")
            except (ValueError, ArithmeticError) as error:
                raise FileError(f"{path}:{number}: {error}") from None
    return np.array(times, dtype=np.int64), np.array(numbers, dtype=float).reshape(len(times), columns - 1)


def read_trajectory(path: str) -> Trajectory:
    """Reads rows `t tx ty tz qx qy qz qw` (TUM). Raises FileError with file and line."""
    t_ns, rows = _rows(path, 8)
    return Trajectory(t_ns, rows[:, :3], rows[:, [6, 3, 4, 5]])


def read_covariances(path: str) -> Tuple[np.ndarray, np.ndarray]:
    """Reads times and covariances (n, 6, 6) of the right perturbation [translation; rotation]. Raises FileError."""
    t_ns, rows = _rows(path, 37)
    return t_ns, rows.reshape(-1, 6, 6)


def _read_json(path: str) -> Dict[str, Any]:
    try:
        with open(path, encoding="utf-8") as file:
            values = json.load(file)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path}: {error}") from None
    if not isinstance(values, dict):
        raise FileError(f"{path}: is not a JSON object")
    return values


def _read_table(path: str) -> Dict[str, np.ndarray]:
    """Reads columns by name; as numbers if all values of a column are numbers."""
    try:
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileError(f"{path}: {error}") from None
    if not rows:
        raise FileError(f"{path}: is empty")
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise FileError(f"{path}:{number}: {len(row)} columns instead of {len(rows[0])}")
    table = {}
    for name, column in zip(rows[0], zip(*rows[1:]) if len(rows) > 1 else [()] * len(rows[0])):
        values = np.array(column)
        try:
            table[name] = values.astype(np.int64)
        except (ValueError, OverflowError):
            try:
                table[name] = np.array([float(v) if v else np.nan for v in column])
            except ValueError:
                table[name] = values
    return table
