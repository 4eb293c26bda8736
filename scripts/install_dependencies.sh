#!/usr/bin/env bash
# Installs what Trunnion needs on a Debian 12 machine: Debian's packages, as root or with sudo, and, for the page of `trunnion
# report`, the Node.js packages of web/package-lock.json. Does nothing, in well under a second, where all of it is there.
#   scripts/install_dependencies.sh [--browser] [--python] [--docs] [--developer]
#                                                 --browser: Chromium, for the tests of the page
#                                                 --python: what the Python module and its tests need
#                                                 --docs: Sphinx and Doxygen, for scripts/build_docs.sh
#                                                 --developer: also clang 19 with its sanitizers and libFuzzer, clang-tidy,
#                                                 clang-format, gcovr
set -euo pipefail
packages=(g++ cmake ninja-build ccache pkg-config zlib1g-dev libeigen3-dev libfmt-dev libtomlplusplus-dev libcli11-dev
          nlohmann-json3-dev libgtest-dev libbenchmark-dev coinor-libclp-dev python3 python3-numpy
          libceres-dev libocct-data-exchange-dev libtbb-dev)
developer=(clang-19 libclang-rt-19-dev clang-tidy-19 clang-format-19 gcovr)
python=(python3-dev pybind11-dev python3-pytest python3-matplotlib python3-nlopt python3-distributed)
docs=(doxygen python3-sphinx python3-myst-parser furo)
for option in "$@"; do
  case $option in
    --developer) packages+=("${developer[@]}" chromium) ;;
    --browser) packages+=(chromium) ;;
    --python) packages+=("${python[@]}") ;;
    --docs) packages+=("${docs[@]}") ;;
  esac
done
# Node.js may be there from elsewhere than Debian.
command -v node >/dev/null && command -v npm >/dev/null || packages+=(nodejs npm)
missing=()
# dpkg-query fails where it has never heard of a package.
installed=$({ dpkg-query -W -f='${db:Status-Abbrev}${Package}\n' "${packages[@]}" 2>/dev/null || true; } | sed -n 's/^ii *//p')
for package in "${packages[@]}"; do
  grep -qx "$package" <<<"$installed" || missing+=("$package")
done
if [ ${#missing[@]} -ne 0 ]; then
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "needed: apt-get install ${missing[*]} (neither root nor sudo here)" >&2; exit 1; }
    as_root=(sudo)
  fi
  echo "installing ${missing[*]}" >&2
  "${as_root[@]}" apt-get update -qq >&2
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
fi
# Without these packages the program builds too, and `report` says that they are missing.
cd "$(dirname "$0")/../web"
[ node_modules/.package-lock.json -nt package-lock.json ] && exit 0
echo "installing the packages of web/package-lock.json" >&2
npm ci --no-audit --no-fund --loglevel=error >&2 || echo "npm ci did not end well: trunnion will be built without the page of \`report\`" >&2
