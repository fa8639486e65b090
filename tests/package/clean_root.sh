#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# clean_root.sh PACKAGE.deb FOLDER [ARCHITECTURE]: makes a minimal Debian 12 in FOLDER, has apt install the package there with
# what it asks for, and runs the first frames of scripts/demo inside, as an ordinary user, within a minute (with another
# architecture than that of this machine, under QEMU, ten). Needs root, mmdebstrap and a mirror ($DEBIAN_MIRROR, or Debian's
# own); FOLDER is left behind.
set -eu
package=$1
root=$2
own=$(dpkg --print-architecture)
architecture=${3:-$own}
limit_s=60
[ "$architecture" = "$own" ] || limit_s=600
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}

mmdebstrap --quiet --mode=root --architectures="$architecture" --variant=apt bookworm "$root" "$mirror"
cp "$package" "$root/tmp/plslam.deb"
[ ! -e /etc/resolv.conf ] || cp /etc/resolv.conf "$root/etc/resolv.conf"
chroot "$root" apt-get update -qq
DEBIAN_FRONTEND=noninteractive chroot "$root" apt-get install -y -qq --no-install-recommends /tmp/plslam.deb

# Nothing of the host's environment: what the programs need they must have from the package.
chroot "$root" useradd --create-home visitor
cat >"$root/tmp/try" <<'END'
set -eu
cd
test "$(id -u)" != 0
test -z "$(command -v c++ cc gcc cmake)"
plslam --version
plslam run 'synthetic:room?frames=30' --out out --save-map room.plmap --quiet
test -s out/trajectory.tum
test -s out/map.ply
test -s out/report.html
plslam export room.plmap --out exported --quiet
test -s exported/map.ply
END
# A namespace of its own for mounts: whatever happens, nothing stays mounted in FOLDER.
unshare --mount --propagation private sh -c '
  mount -t proc proc "$0/proc"
  exec timeout "$1" chroot --userspec=visitor:visitor "$0" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/home/visitor sh /tmp/try' \
  "$root" "$limit_s"
echo "clean root: installed and run"
