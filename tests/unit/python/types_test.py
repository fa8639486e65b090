# SPDX-License-Identifier: BSD-3-Clause
"""Types: mypy finds no error in the package. The generated types of messages have none."""

import pathlib
import shutil
import subprocess
import sys

import plslam
import pytest


def test_types_pass_mypy(source):
    if shutil.which("mypy") is None:
        pytest.skip("no mypy here")
    files = sorted(f"plslam/{path.name}" for path in source.glob("tools/python/plslam/*.py"))
    assert len(files) > 5
    flags = ["--cache-dir=/dev/null", "--disallow-untyped-defs", "--follow-imports=silent", "--explicit-package-bases"]
    done = subprocess.run(
        ["mypy", *flags, "--python-executable", sys.executable, *files],
        cwd=pathlib.Path(plslam.__file__).parents[1],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
