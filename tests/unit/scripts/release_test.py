# SPDX-License-Identifier: BSD-3-Clause
"""Tests the notes, the checksums and the refusals of scripts/release, in a copy of the few files that it reads."""
import hashlib
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "scripts" / "release"
CHANGELOG = "# Changes\n\n## 1.2.0 (not released)\n\n* New: a.\n  More of a.\n* b.\n\n## 1.1.0\n\n* Old.\n"


class Release(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "scripts").mkdir()
        shutil.copy(SCRIPT, self.folder / "scripts")
        (self.folder / "CMakeLists.txt").write_text("project(plslam VERSION 1.2.0 LANGUAGES C CXX)\n")
        (self.folder / "CHANGELOG.md").write_text(CHANGELOG)
        self.files = self.folder / "build" / "release-files"

    def run_script(self, *parts, path=os.environ["PATH"]):
        return subprocess.run(["/bin/sh", str(self.folder / "scripts" / "release"), *parts], capture_output=True, text=True,
                              env={"PATH": path})

    def test_notes_are_the_section_of_this_version(self):
        done = self.run_script("notes")
        self.assertEqual(done.returncode, 0, done.stderr)
        notes = (self.files / "NOTES.md").read_text()
        self.assertEqual(notes.strip(), "* New: a.\n  More of a.\n* b.")
        self.assertIn("calls 1.2.0 'not released'", done.stdout)
        digest = hashlib.sha256(notes.encode()).hexdigest()
        self.assertEqual((self.files / "SHA256SUMS").read_text(), f"{digest}  NOTES.md\n")

    def test_a_version_without_notes_is_an_error(self):
        (self.folder / "CHANGELOG.md").write_text(CHANGELOG.replace("1.2.0", "1.20"))
        done = self.run_script("notes")
        self.assertEqual(done.returncode, 1)
        self.assertIn("CHANGELOG.md has no section '## 1.2.0'", done.stderr)

    def test_a_part_that_cannot_be_made_does_not_prevent_the_others(self):
        tools = self.folder / "tools"
        tools.mkdir()
        for name in "sh dirname sed awk grep rm mkdir find sort xargs sha256sum cat".split():
            (tools / name).symlink_to(shutil.which(name))
        done = self.run_script(path=str(tools))
        self.assertEqual(done.returncode, 1)
        for sentence in ("error: amd64: there is no dpkg-deb here", "error: arm64: there is no aarch64-linux-gnu-g++ here",
                         "error: image: neither podman nor docker runs here", "not made: amd64 arm64 image"):
            self.assertIn(sentence, done.stderr)
        self.assertTrue((self.files / "NOTES.md").exists())

    def test_an_unknown_part_makes_nothing(self):
        done = self.run_script("notes", "windows")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no part 'windows'", done.stderr)
        self.assertFalse(self.files.exists())


if __name__ == "__main__":
    unittest.main()
