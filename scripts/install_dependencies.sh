#!/usr/bin/env bash
# Installs what Trunnion needs on a Debian 12 machine, from Debian's packages only. As root or with sudo. Does nothing, in
# well under a second, where all of it is there.
#   scripts/install_dependencies.sh [--developer]     also clang 19 with its sanitizers and libFuzzer, clang-tidy,
#                                                 clang-format, gcovr
set -euo pipefail
packages=(g++ cmake ninja-build ccache pkg-config zlib1g-dev libeigen3-dev libfmt-dev libtomlplusplus-dev libcli11-dev
          nlohmann-json3-dev libgtest-dev libbenchmark-dev coinor-libclp-dev python3 python3-numpy)
[ "${1:-}" = --developer ] && packages+=(clang-19 libclang-rt-19-dev clang-tidy-19 clang-format-19 gcovr)
missing=()
installed=$(dpkg-query -W -f='${db:Status-Abbrev}${Package}\n' "${packages[@]}" 2>/dev/null | sed -n 's/^ii *//p')
for package in "${packages[@]}"; do
  grep -qx "$package" <<<"$installed" || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "needed: apt-get install ${missing[*]} (neither root nor sudo here)" >&2; exit 1; }
  as_root=(sudo)
fi
echo "installing ${missing[*]}" >&2
"${as_root[@]}" apt-get update -qq >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
