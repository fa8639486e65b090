#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# also_in_root.sh ROOT PACKAGE.deb COMMANDS: installs one more package in a bare root of clean_root.sh, and runs COMMANDS (a script
# for sh) there as an ordinary user, within a minute in all. ROOT itself is not changed: what is written is in memory.
set -eu
root=$1
package=$2
commands=$3
# A namespace of its own for mounts: whatever happens, nothing stays mounted.
exec timeout 60 unshare --mount --propagation private sh -euc '
  mount -t tmpfs none /mnt
  mkdir /mnt/written /mnt/work /mnt/root
  mount -t overlay overlay -o "lowerdir=$0,upperdir=/mnt/written,workdir=/mnt/work" /mnt/root
  mount -t proc proc /mnt/root/proc
  cp "$1" /mnt/root/tmp/package.deb
  DEBIAN_FRONTEND=noninteractive chroot /mnt/root apt-get install -y -qq --no-install-recommends /tmp/package.deb
  printf "set -eu\ncd\n%s\n" "$2" >/mnt/root/tmp/try
  chroot --userspec=visitor:visitor /mnt/root /usr/bin/env -i PATH=/usr/bin:/bin HOME=/home/visitor sh /tmp/try' \
  "$root" "$package" "$commands"
