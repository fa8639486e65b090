#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""play_containerfile.py CONTAINERFILE FOLDER [--check]: executes a Containerfile without a container engine, as root: each
stage is a Debian of its own in FOLDER, made by mmdebstrap from $DEBIAN_MIRROR (or Debian's own), in which the RUN lines run.
Then the entry point of the last stage, if it has one, plays a short world. --check reads the file only. It knows the
instructions that are used here and refuses others."""
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

SUITES = {"debian:12": "bookworm", "debian:12-slim": "bookworm"}
# If a proxy of the host has its own certificates, npm needs them, too.
CERTIFICATES = os.environ.get("NODE_EXTRA_CA_CERTS")
MIRROR = os.environ.get("DEBIAN_MIRROR", "http://deb.debian.org/debian")


class Stage:
    def __init__(self, image, name, root):
        self.image, self.name, self.root = image, name, root
        self.folder = "/"
        self.steps = []  # (what, arguments)
        self.entry_point = []


def read_stages(path, folder):
    stages = []
    lines = re.sub(r"\\\n", " ", path.read_text()).splitlines()
    for line in (line.strip() for line in lines):
        if not line or line.startswith("#"):
            continue
        instruction, _, rest = line.partition(" ")
        words = rest.split()
        if instruction == "FROM" and words[0] in SUITES:
            name = words[2] if len(words) == 3 and words[1] == "AS" else str(len(stages))
            stages.append(Stage(words[0], name, folder / name))
        elif instruction == "COPY" and words[0].startswith("--from="):
            source = next(stage for stage in stages if stage.name == words[0].removeprefix("--from="))
            stages[-1].steps.append(("copy", (source.root, words[1], words[2])))
        elif instruction == "COPY" and words[0] == ".":
            stages[-1].steps.append(("copy_tree", (path.parent, words[1])))
        elif instruction == "WORKDIR":
            stages[-1].folder = words[0]
            stages[-1].steps.append(("folder", (words[0],)))
        elif instruction == "RUN":
            stages[-1].steps.append(("run", (stages[-1].folder, rest)))
        elif instruction == "ENTRYPOINT":
            stages[-1].entry_point = json.loads(rest)
        elif instruction != "CMD":
            raise SystemExit(f"{path}: '{line}' is not known here")
    return stages


def chroot(root, folder, command):
    # A separate mount namespace: nothing stays mounted, whatever happens.
    inside = f"cd {shlex.quote(folder)} && {command}"
    script = 'mount -t proc proc "$0/proc" && mount --bind /dev "$0/dev" && exec chroot "$0" /usr/bin/env -i "$@"'
    environment = ["PATH=/usr/sbin:/usr/bin:/sbin:/bin", "HOME=/root", "DEBIAN_FRONTEND=noninteractive"]
    if CERTIFICATES:
        environment.append("NODE_EXTRA_CA_CERTS=/host_certificates.crt")
    subprocess.run(["unshare", "--mount", "--propagation", "private", "sh", "-c", script, root, *environment,
                    "sh", "-c", inside], check=True)


def play(stage):
    print(f"FROM {stage.image}", flush=True)
    subprocess.run(["mmdebstrap", "--quiet", "--mode=root", "--variant=apt", SUITES[stage.image], stage.root, MIRROR],
                   check=True)
    if os.path.exists("/etc/resolv.conf"):
        shutil.copy("/etc/resolv.conf", stage.root / "etc/resolv.conf")
    if CERTIFICATES:
        shutil.copy(CERTIFICATES, stage.root / "host_certificates.crt")
    for what, arguments in stage.steps:
        print(what, *arguments, flush=True)
        if what == "copy":
            source_root, source, target = arguments
            shutil.copytree(f"{source_root}{source}", f"{stage.root}{target}")
        elif what == "copy_tree":
            source, target = arguments
            left_out = [pattern.strip() for pattern in (source / ".containerignore").read_text().split()]
            keep = lambda folder, names: [n for n in names if pathlib.Path(folder) == source and n in left_out]
            shutil.copytree(source, f"{stage.root}{target}", symlinks=True, ignore=keep)
        elif what == "folder":
            os.makedirs(f"{stage.root}{arguments[0]}", exist_ok=True)
        else:
            chroot(stage.root, *arguments)


def main():
    path, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    stages = read_stages(path, folder)
    last = stages[-1]
    if "--check" not in sys.argv:
        folder.mkdir(parents=True, exist_ok=True)
        for stage in stages:
            play(stage)
        if last.entry_point:
            chroot(last.root, last.folder, shlex.join(
                [*last.entry_point, "run", "synthetic:room?size=320x200&frames=30", "--out", "/out/room", "--quiet"]))
            if not os.path.exists(f"{last.root}/out/room/trajectory.tum"):
                raise SystemExit("the run has left no trajectory")
    print(f"containerfile: {len(stages)} stages, {sum(len(stage.steps) for stage in stages)} steps")


if __name__ == "__main__":
    main()
