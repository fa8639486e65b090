# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces and grids: files as dense_process writes them (docs/planning.md). RoomProducts.* reads those of a world."""

import struct

import numpy as np
import plslam
import pytest

POINTS = [
    # position, normal, colour
    ((0.5, 1.25, -2.0), (0.0, 0.0, 1.0), (7, 8, 9)),
    ((1.5, 1.25, -2.0), (0.0, 1.0, 0.0), (255, 0, 1)),
    ((1.5, 2.25, -2.0), (1.0, 0.0, 0.0), (0, 0, 0)),
]
PROPERTIES = "".join(f"property float {name}\n" for name in "x y z nx ny nz".split()) + "".join(
    f"property uchar {name}\n" for name in "red green blue".split()
)
FREE, OCCUPIED, UNKNOWN = 254, 0, 205  # greys of the image of a grid


def ply(triangles=None, n_points=len(POINTS)):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {n_points}\n{PROPERTIES}"
    if triangles is not None:
        head += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\n"
    body = b"".join(struct.pack("<6f3B", *position, *normal, *colour) for position, normal, colour in POINTS)
    body += b"".join(struct.pack("<B3i", 3, *triangle) for triangle in triangles or [])
    return head.encode() + b"end_header\n" + body


@pytest.fixture
def read(tmp_path):
    def read_bytes(data):
        path = tmp_path / "mesh.ply"
        path.write_bytes(data)
        return plslam.read_surface(str(path))

    return read_bytes


@pytest.fixture
def grid_folder(tmp_path):
    """A grid of three columns and two rows; the first row of the image is that of the largest y."""
    (tmp_path / "map.yaml").write_text(
        "image: map.pgm\nmode: trinary\nresolution: 0.5\norigin: [-1, 2, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    image = bytes([UNKNOWN, FREE, OCCUPIED, FREE, FREE, UNKNOWN])
    (tmp_path / "map.pgm").write_bytes(b"P5\n3 2\n255\n" + image)
    return tmp_path


def test_a_mesh_has_points_and_triangles(read):
    mesh = read(ply([(0, 1, 2), (2, 1, 0)]))
    assert mesh.position_m.tolist() == [list(position) for position, _, _ in POINTS]
    assert mesh.normal.tolist() == [list(normal) for _, normal, _ in POINTS]
    assert mesh.colour.tolist() == [list(colour) for _, _, colour in POINTS]
    assert mesh.triangles.tolist() == [[0, 1, 2], [2, 1, 0]]


def test_a_cloud_has_no_triangles(read):
    cloud = read(ply())
    assert len(cloud.position_m) == 3 and cloud.triangles is None


def test_arrays_of_a_surface_may_be_changed(read):
    mesh = read(ply([(0, 1, 2)]))
    mesh.position_m += 1
    mesh.triangles[0] = 0
    assert mesh.position_m[0].tolist() == [1.5, 2.25, -1.0]


@pytest.mark.parametrize(
    "data, sentence",
    [
        (b"", "is not a cloud or mesh of dense_process"),
        (ply().replace(b"binary_little_endian", b"ascii"), "is not a cloud or mesh of dense_process"),
        (ply().replace(b"float nx", b"float u"), "is not a cloud or mesh of dense_process"),
        (ply([(0, 1, 2)])[:-1], "bytes after its header, not those of 3 points and 1 triangles"),
        (ply() + b"x", "bytes after its header, not those of 3 points and 0 triangles"),
        (ply(n_points=10**12), "bytes after its header, not those of 1000000000000 points and 0 triangles"),
        (ply([(0, 1, 3)]), "a triangle has no such points: it is damaged"),
        (ply([(0, 1, -1)]), "a triangle has no such points: it is damaged"),
    ],
    ids=["empty", "text", "other members", "short", "long", "huge count", "point too large", "negative point"],
)
def test_damaged_surfaces_raise_one_sentence(read, tmp_path, data, sentence):
    with pytest.raises(plslam.FileError) as error:
        read(data)
    assert str(error.value).startswith(f"{tmp_path / 'mesh.ply'}: ") and str(error.value).endswith(sentence)


def test_a_grid_begins_at_its_lower_left_corner(grid_folder):
    for path in (grid_folder, grid_folder / "map.yaml"):
        grid = plslam.read_grid(str(path))
        assert grid.cells.tolist() == [
            [grid.FREE, grid.FREE, grid.UNKNOWN],
            [grid.UNKNOWN, grid.FREE, grid.OCCUPIED],
        ]
        assert grid.resolution_m == 0.5 and grid.origin_m.tolist() == [-1, 2]


@pytest.mark.parametrize(
    "x_m, y_m, cell",
    [
        (-0.9, 2.1, plslam.Grid.FREE),
        (0.4, 2.6, plslam.Grid.OCCUPIED),
        (0.4, 2.4, plslam.Grid.UNKNOWN),
        (-1.1, 2.1, plslam.Grid.UNKNOWN),
        (0.6, 2.6, plslam.Grid.UNKNOWN),
        (1e6, 0.0, plslam.Grid.UNKNOWN),
    ],
    ids=["free", "occupied", "unknown", "left of it", "right of it", "far away"],
)
def test_the_cell_at_a_position(grid_folder, x_m, y_m, cell):
    assert plslam.read_grid(str(grid_folder)).cell(x_m, y_m) == cell


@pytest.mark.parametrize(
    "name, data, sentence",
    [
        ("map.yaml", b"image: map.pgm\n", "is not a grid of dense_process: 'resolution'"),
        ("map.yaml", b"image: map.pgm\nresolution: wide\norigin: [0, 0, 0]\n", "is not a grid of dense_process: "),
        ("map.pgm", b"P5\n3 2\n255\n" + bytes(5), "is damaged, or not a binary PGM"),
        ("map.pgm", b"P2\n3 2\n255\n" + bytes(6), "is damaged, or not a binary PGM"),
    ],
    ids=["no resolution", "no number", "short image", "text image"],
)
def test_damaged_grids_raise_one_sentence(grid_folder, name, data, sentence):
    (grid_folder / name).write_bytes(data)
    with pytest.raises(plslam.FileError) as error:
        plslam.read_grid(str(grid_folder))
    assert str(error.value).startswith(f"{grid_folder / name}: {sentence}")


def test_greys_of_a_grid_are_those_of_the_map_server(grid_folder):
    """The three greys, and no others, have a meaning: docs/planning.md."""
    (grid_folder / "map.pgm").write_bytes(b"P5\n3 2\n255\n" + bytes([1, 253, 255, 0, 254, 205]))
    grid = plslam.read_grid(str(grid_folder))
    assert np.array_equal(grid.cells, [[grid.OCCUPIED, grid.FREE, grid.UNKNOWN], 3 * [grid.UNKNOWN]])
