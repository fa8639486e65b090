# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces and grids of dense_process as arrays. docs/planning.md describes their files."""

import pathlib
import re
from dataclasses import dataclass
from typing import Optional

import numpy as np

from .errors import FileError

_VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("colour", "u1", 3)])
_FACE = np.dtype([("n", "u1"), ("vertices", "<i4", 3)])
_PROPERTIES = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"]


@dataclass
class Surface:
    """Points of surfaces in w, the frame of trajectory.tum; triangles if it is a mesh."""

    position_m: np.ndarray  # (n, 3) float32
    normal: np.ndarray  # (n, 3) float32, towards free space
    colour: np.ndarray  # (n, 3) uint8
    triangles: Optional[np.ndarray]  # (m, 3) int32, rows of position_m; None: a cloud


@dataclass
class Grid:
    """The floor of a map, in its level frame. Cell [y, x] covers origin_m + resolution_m * ([x, y] .. [x + 1, y + 1])."""

    FREE = 0
    OCCUPIED = 100
    UNKNOWN = -1

    cells: np.ndarray  # (height, width) int8: FREE, OCCUPIED or UNKNOWN, as in nav_msgs/OccupancyGrid
    resolution_m: float
    origin_m: np.ndarray  # (2,): x, y of the lower left corner of cell [0, 0]

    def cell(self, x_m: float, y_m: float) -> int:
        """The cell at a position; UNKNOWN outside."""
        column, row = np.floor((np.array([x_m, y_m]) - self.origin_m) / self.resolution_m).astype(int)
        inside = 0 <= row < self.cells.shape[0] and 0 <= column < self.cells.shape[1]
        return int(self.cells[row, column]) if inside else self.UNKNOWN


def read_surface(path: str) -> Surface:
    """Reads cloud.ply or mesh.ply. Raises FileError if the file is damaged or not one of these."""
    data = pathlib.Path(path).read_bytes()
    head, end, body = data.partition(b"end_header\n")
    lines = head.decode("ascii", "replace").splitlines()
    counts = {name: int(n) for name, n in re.findall(r"^element (vertex|face) (\d+)$", "\n".join(lines), re.MULTILINE)}
    names = [line.split()[-1] for line in lines if line.startswith("property ")]
    is_mesh = "face" in counts
    known = ["ply", "format binary_little_endian 1.0"]
    if not end or lines[:2] != known or names != _PROPERTIES + ["vertex_indices"] * is_mesh:
        raise FileError(f"{path}: is not a cloud or mesh of dense_process")
    n, m = counts.get("vertex", 0), counts.get("face", 0)
    if len(body) != n * _VERTEX.itemsize + m * _FACE.itemsize:
        raise FileError(f"{path}: has {len(body)} bytes after its header, not those of {n} points and {m} triangles")
    vertices = np.frombuffer(body, _VERTEX, n)
    faces = np.frombuffer(body, _FACE, m, n * _VERTEX.itemsize)
    if np.any(faces["n"] != 3) or np.any(faces["vertices"] < 0) or np.any(faces["vertices"] >= n):
        raise FileError(f"{path}: a triangle has no such points: it is damaged")
    triangles = faces["vertices"].copy() if is_mesh else None
    return Surface(vertices["position"].copy(), vertices["normal"].copy(), vertices["colour"].copy(), triangles)


def read_grid(path: str) -> Grid:
    """Reads map.yaml and its image, or those in a folder. Raises FileError if they are damaged."""
    yaml = pathlib.Path(path)
    if yaml.is_dir():
        yaml = yaml / "map.yaml"
    values = dict(re.findall(r"^(\w+): (.*)$", yaml.read_text(), re.MULTILINE))
    try:
        image = yaml.parent / values["image"]
        resolution_m = float(values["resolution"])
        origin = [float(word) for word in values["origin"].strip("[]").split(",")]
    except (KeyError, ValueError) as error:
        raise FileError(f"{yaml}: is not a grid of dense_process: {error}") from error
    data = image.read_bytes()
    head = re.match(rb"P5\n(\d+) (\d+)\n255\n", data)
    if head is None or len(data) - head.end() != int(head[1]) * int(head[2]):
        raise FileError(f"{image}: is damaged, or not a binary PGM")
    grey = np.frombuffer(data, np.uint8, offset=head.end()).reshape(int(head[2]), int(head[1]))[::-1]
    cells = np.full(grey.shape, Grid.UNKNOWN, np.int8)
    cells[grey == 254] = Grid.FREE
    cells[grey == 0] = Grid.OCCUPIED
    return Grid(cells, resolution_m, np.array(origin[:2]))
