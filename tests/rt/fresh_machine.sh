#!/usr/bin/env bash
# A bare Debian 12, made in a folder by debootstrap: README's first command there, then docs/how-to/run-on-linuxcnc.md command by
# command (how_to_test.py). Processes, shared memory and mounts are its own.     fresh_machine.sh SOURCE_DIR
# Exit status 77: not root, no debootstrap, no package server. Some 15 minutes; CCACHE_DIR, where set, is lent to the machine.
set -euo pipefail
source_folder=$(realpath "$1")
if [ "${2:-}" != inside ]; then
  command -v debootstrap >/dev/null && [ "$(id -u)" -eq 0 ] || exit 77
  exec unshare --mount --ipc --pid --fork -- "$0" "$source_folder" inside
fi

mirror=http://deb.debian.org/debian
machine=$(mktemp -d /var/tmp/fresh-machine-XXXXXX)
chmod 755 "$machine"  # its / is for all users
unmounted() {
  ! findmnt -rno TARGET | grep "^$machine/" | sort -r | xargs -r umount -l
  rm -rf --one-file-system "$machine"
}
trap unmounted EXIT
debootstrap --variant=minbase --include=ca-certificates bookworm "$machine" "$mirror" >"$machine.log" 2>&1 ||
  { grep -q "^E: .*Release" "$machine.log" && exit 77; cat "$machine.log"; exit 1; }
rm "$machine.log"
cp /etc/resolv.conf "$machine/etc/resolv.conf"
mount -t proc proc "$machine/proc"
mount --rbind /dev "$machine/dev"
mount --make-rslave "$machine/dev"
mount -t tmpfs tmpfs "$machine/dev/shm"
# Where a checkout of the same depth has filled the cache it is warm here too.
mkdir -p "$machine/work"
git clone -q --no-local "$source_folder" "$machine/work/trunnion"
if [ -n "${CCACHE_DIR:-}" ]; then
  mkdir "$machine/ccache"
  mount --bind "$CCACHE_DIR" "$machine/ccache"
fi
on_machine() {
  chroot "$machine" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb LC_ALL=C.UTF-8 \
    ${CCACHE_DIR:+CCACHE_DIR=/ccache CCACHE_BASEDIR=/work CCACHE_NOHASHDIR=1} sh -ec "cd /work/trunnion; $1"
}
# What the network here signs with.
cp -r /usr/local/share/ca-certificates "$machine/usr/local/share/"
on_machine 'update-ca-certificates'
on_machine 'scripts/install_dependencies.sh'
on_machine 'cmake --preset release -DTRUNNION_TESTS=OFF -DTRUNNION_BENCH=OFF'
on_machine 'scripts/demo.sh'
on_machine 'scripts/build.sh release'
on_machine '/usr/bin/python3 tests/rt/how_to_test.py build/release .'
