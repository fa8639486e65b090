# SPDX-License-Identifier: BSD-3-Clause
"""Folders of runs: load_run returns what the C++ side has written, and names file and line of damage."""

import pathlib
import shutil

import numpy as np
import plslam
import pytest


@pytest.fixture
def folder(written, tmp_path):
    """A run with trajectories and covariances of the C++ side, a table of frames and a summary."""
    run = tmp_path / "run"
    shutil.copytree(written / "run", run)
    (run / "poses.csv").write_text("frame_id,t_s,state,depth_m\n0,1.5,tracking,2\n1,1.75,lost,\n")
    (run / "summary.json").write_text('{"frames": 2}')
    return run


def column(poses, name):
    return np.array([pose[name] for pose in poses])


def load(folder):
    return plslam.load_run(str(folder))


def test_trajectories_equal_the_written_ones(folder, expected):
    run, poses = load(folder), expected["run"]
    assert len(run.trajectory) == len(poses)
    for trajectory, name in ((run.trajectory, "T"), (run.live, "T_live")):
        assert trajectory.t_ns.tolist() == [pose["t_ns"] for pose in poses], "nanoseconds since 1970 are exact"
        # Files have nine decimals.
        assert np.abs(trajectory.matrices() - column(poses, name)).max() < 1e-7
    assert run.keyframes is None and run.truth is None


def test_covariances_equal_the_written_ones(folder, expected):
    t_ns, covariance = load(folder).covariance
    assert t_ns.tolist() == [pose["t_ns"] for pose in expected["run"]]
    assert np.array_equal(covariance, column(expected["run"], "covariance"))


def test_each_file_has_its_member(folder):
    shutil.copy(folder / "trajectory.tum", folder / "keyframes.tum")
    shutil.copy(folder / "trajectory_live.tum", folder / "groundtruth.tum")
    shutil.copy(folder / "covariance.txt", folder / "motion_covariance.txt")
    run = load(folder)
    assert np.array_equal(run.keyframes.position_m, run.trajectory.position_m)
    assert np.array_equal(run.truth.position_m, run.live.position_m)
    assert np.array_equal(run.motion_covariance[1], run.covariance[1])


def test_table_of_frames_has_numbers_and_words(folder):
    run = load(folder)
    assert run.summary == {"frames": 2}
    assert list(run.frames) == ["frame_id", "t_s", "state", "depth_m"]
    assert run.frames["frame_id"].dtype == np.int64 and run.frames["frame_id"].tolist() == [0, 1]
    assert run.frames["t_s"].tolist() == [1.5, 1.75]
    assert run.frames["state"].tolist() == ["tracking", "lost"]
    assert run.frames["depth_m"][0] == 2 and np.isnan(run.frames["depth_m"][1]), "an empty cell is not a number"


def test_table_without_frames_has_empty_columns(folder):
    (folder / "poses.csv").write_text("frame_id,t_s\n")
    assert {name: len(values) for name, values in load(folder).frames.items()} == {"frame_id": 0, "t_s": 0}


def test_the_map_of_a_run_is_read_if_there_is_one(folder, written):
    assert load(folder).map is None
    shutil.copy(written / "small.plmap", folder / "room.plmap")
    assert len(load(folder).map.keyframes.id) > 0
    shutil.copy(written / "small.plmap", folder / "other.plmap")
    assert load(folder).map is None, "none of two is the map of the run"


def test_a_trajectory_may_have_comments(folder):
    (folder / "trajectory.tum").write_text("# t x y z\n\n1.000000001 2 3 4 0 0 0 1\n")
    trajectory = load(folder).trajectory
    assert trajectory.t_ns.tolist() == [1_000_000_001]
    assert trajectory.position_m.tolist() == [[2, 3, 4]] and trajectory.q_wxyz.tolist() == [[1, 0, 0, 0]]


@pytest.mark.parametrize(
    "name, text, sentence",
    [
        ("trajectory.tum", "1 2 3 4 0 0 0 1\n2 2 x 4 0 0 0 1\n", ":2: could not convert string to float: 'x'"),
        ("trajectory.tum", "# nothing\n\n1 2 3\n", ":3: 3 numbers instead of 8"),
        ("trajectory.tum", "1 2 nan 4 0 0 0 1\n", ":1: a number that is not finite"),
        ("trajectory.tum", "1e30 2 3 4 0 0 0 1\n", ":1: the time 1e30 s is beyond "),
        ("trajectory.tum", "1e999999 2 3 4 0 0 0 1\n", ":1: the time 1e999999 s is beyond "),
        ("trajectory.tum", "noon 2 3 4 0 0 0 1\n", ":1: "),
        ("trajectory_live.tum", "\xff\n", ":1: 1 numbers instead of 8"),
        ("covariance.txt", "1 2 3\n", ":1: 3 numbers instead of 37"),
        ("summary.json", "{", ": "),
        ("summary.json", "[]", ": is not a JSON object"),
        ("summary.json", 100_000 * "[", ": "),
        ("poses.csv", "a,b\n1\n", ":2: 1 columns instead of 2"),
        ("poses.csv", "a,\xff\n1,2\n", ": 'utf-8' codec"),
        ("poses.csv", "", ": is empty"),
    ],
)
def test_damage_is_named_with_file_and_line(folder, name, text, sentence):
    (folder / name).write_text(text, encoding="latin-1")
    with pytest.raises(plslam.FileError) as error:
        load(folder)
    assert str(error.value).startswith(f"{folder / name}{sentence}")
    assert "\n" not in str(error.value)


def test_an_integer_beyond_64_bits_is_a_number(folder):
    (folder / "poses.csv").write_text("a\n" + 30 * "9" + "\n")
    assert load(folder).frames["a"].tolist() == [1e30]


def test_a_folder_without_a_run_is_named(tmp_path):
    with pytest.raises(plslam.FileError, match="has no file of a run: `plslam run --out .*` writes them$"):
        load(tmp_path)
    with pytest.raises(plslam.FileError, match="none: is not a folder$"):
        load(pathlib.Path(tmp_path / "none"))
