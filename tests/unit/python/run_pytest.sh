#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# run_pytest.sh BUILD [ARGUMENTS]: runs the tests of the Python package of a build, as ctest does, with arguments for
# pytest: run_pytest.sh build/release maps_test.py -k truncation. The exit code is 77, "skipped" for ctest, if there is
# no Python with numpy and pytest, or a test was skipped.
set -eu
build=$(cd "$1" && pwd)
shift
cd "$(dirname "$0")"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# Debian's Python, if the first one in the path has no numpy.
for python in python3 /usr/bin/python3; do
  if "$python" -c 'import numpy, pytest' 2>/dev/null; then
    # Plugins of this machine are not loaded: all machines run the same tests.
    export PYTHONPATH="$build/python" PYTHONDONTWRITEBYTECODE=1 PYTEST_DISABLE_PLUGIN_AUTOLOAD=1
    export PLSLAM_PYTHON_FIXTURES="$build/tests/python_fixtures"
    status=0
    "$python" -m pytest -p no:cacheprovider --basetemp="$folder/files" -q -rs "$@" || status=$?
    exit "$status"
  fi
done
echo "skipped: no Python with numpy and pytest here (python3-numpy, python3-pytest)"
exit 77
