# SPDX-License-Identifier: BSD-3-Clause
"""Examples: those of tools/python/examples, and the one in docs/python.md, on files with its names.

AdapterPython.ImagesOfNumpyAreTracked runs send_images.py with the whole system.
"""

import ast
import re
import runpy
import shutil
import subprocess
import sys
import types

import numpy as np
import plslam
import pytest


@pytest.fixture(scope="module")
def examples(source):
    return source / "tools/python/examples"


def test_the_example_of_the_document_runs(source, written, tmp_path, monkeypatch, capsys):
    shutil.copy(written / "room.plmap", tmp_path)
    shutil.copy(written / "run.lcm", tmp_path)
    shutil.copytree(written / "run", tmp_path / "out/room")
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"^```python\n(.*?)^```", (source / "docs/python.md").read_text(), re.MULTILINE | re.DOTALL)
    values = {}
    exec(code, values)
    printed = capsys.readouterr().out
    assert "f_px=420.5" in printed
    assert "observations of a point, at most: " in printed
    assert "vo running" in printed
    assert values["error"].shape == (30, 3)


def test_map_to_arrays_writes_points_lines_and_path(examples, written, expected, tmp_path):
    out = tmp_path / "out.npz"
    done = subprocess.run(
        [sys.executable, examples / "map_to_arrays.py", written / "room.plmap", out],
        check=True,
        capture_output=True,
        text=True,
    )
    room, arrays = expected["map"], np.load(out)
    lines = len(room["lines"])
    assert done.stdout == f"{len(room['points'])} points, {lines} lines, {len(room['keyframes'])} keyframes\n"
    assert np.array_equal(arrays["points"], [point["p_w"] for point in room["points"]])
    assert arrays["line_ends"].shape == (2 * lines, 3) and arrays["lines"].shape == (lines, 2)
    ends = arrays["line_ends"][arrays["lines"][-1]]
    assert np.array_equal(ends, [room["lines"][-1]["p_w"], room["lines"][-1]["q_w"]])
    path = [np.array(keyframe["T_w_kf"])[:3, 3] for keyframe in room["keyframes"]]
    assert np.array_equal(arrays["path"], path)


class EnoughDrawn(Exception):
    pass


def test_live_plot_draws_the_path_of_a_run(examples, url, publisher, monkeypatch):
    """A drawing library records the calls, and ends the example after three pictures."""
    drawn = []

    class Line:
        def set_data(self, x, z):
            drawn.append((list(x), list(z)))
            if len(drawn) == 3:
                raise EnoughDrawn

    def nothing(*_):
        pass

    axes = types.SimpleNamespace(set_aspect=nothing, relim=nothing, autoscale_view=nothing)
    pyplot = types.ModuleType("matplotlib.pyplot")
    vars(pyplot).update({name: nothing for name in "xlabel ylabel ion show pause".split()})
    vars(pyplot).update(plot=lambda x, z: (Line(),), gca=lambda: axes)
    package = types.ModuleType("matplotlib")
    package.pyplot = pyplot
    monkeypatch.setitem(sys.modules, "matplotlib", package)
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", pyplot)
    monkeypatch.setattr(sys, "argv", ["live_plot.py", url])

    publisher()
    with pytest.raises(EnoughDrawn):
        runpy.run_path(str(examples / "live_plot.py"))
    x, z = drawn[-1]
    assert [len(z) for _, z in drawn] == [10, 20, 30]
    assert x == 30 * [0.0]
    # Each frame is 0.25 m beyond the one before it; some may be missing.
    assert np.diff(z).min() >= 0.25 and np.all(np.mod(z, 0.25) == 0)


def test_every_example_is_in_the_document(examples, source):
    document = (source / "docs/python.md").read_text()
    paths = sorted(examples.glob("*.py"))
    assert len(paths) > 3
    for path in paths:
        usage = ast.get_docstring(ast.parse(path.read_text()))
        assert usage.startswith(path.name), "the docstring begins with the usage"
        assert f"* `{path.name}" in document


def test_every_function_is_in_the_document(source):
    """Each function and class that users call has a row in docs/python.md and a docstring."""
    document = (source / "docs/python.md").read_text()
    for name in "load_map load_run read_surface read_grid read_log listen ImageSender transform".split():
        assert f"`{name}(" in document and getattr(plslam, name).__doc__
