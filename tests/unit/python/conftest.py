# SPDX-License-Identifier: BSD-3-Clause
"""Fixtures of the tests of the Python package: files and messages of the C++ side, written by python_fixtures.

run_pytest.sh runs the tests, also by hand.
"""

import contextlib
import json
import os
import pathlib
import random
import subprocess

import pytest

SKIPPED = 77


@pytest.fixture(scope="session")
def source():
    """The root of the source tree."""
    return pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def fixtures_program():
    return os.environ["PLSLAM_PYTHON_FIXTURES"]


@pytest.fixture(scope="session")
def written(tmp_path_factory, fixtures_program):
    """A folder of maps, logs and the files of a run; python_fixtures.cpp lists them."""
    folder = tmp_path_factory.mktemp("written")
    subprocess.run([fixtures_program, "files", str(folder)], check=True)
    return folder


@pytest.fixture(scope="session")
def expected(written):
    """The values in the files of `written`, with all digits."""
    return json.loads((written / "expected.json").read_text())


@pytest.fixture
def url():
    """An LCM URL of this test: a random multicast group and port that never leave the host."""
    draw = random.SystemRandom().randrange
    # Ports below 32,768 are not given to other sockets by the system.
    return f"udpm://239.255.{draw(100, 200)}.{draw(1, 251)}:{draw(20000, 32000)}?ttl=0"


@pytest.fixture
def publisher(url, fixtures_program):
    """Starts the C++ side's publisher of POSE at `url`, with a prefix; it ends with the test."""
    with contextlib.ExitStack() as running:

        def start(prefix=""):
            process = running.enter_context(subprocess.Popen([fixtures_program, "publish", url, prefix]))
            running.callback(process.kill)

        yield start


def pytest_sessionfinish(session, exitstatus):
    """Makes skipped tests visible in ctest: without failures, the exit code is that of a skipped file."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if exitstatus == pytest.ExitCode.OK and reporter.stats.get("skipped"):
        session.exitstatus = SKIPPED
