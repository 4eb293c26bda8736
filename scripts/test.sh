#!/usr/bin/env bash
# From a bare Debian 12 machine to the verdict of all tests: installs what is missing, builds, checks that every public header
# compiles alone, runs ctest.   scripts/test.sh [PRESET] [ctest option…]     preset: release (default), dev, asan, tsan, clang;
# tidy: builds with clang-tidy, which is its verdict
set -euo pipefail
cd "$(dirname "$0")/.."
preset=release
case "${1:-}" in release|dev|asan|tsan|clang|tidy) preset=$1; shift ;; esac
case $preset in clang|tidy) scripts/install_dependencies.sh --developer ;; *) scripts/install_dependencies.sh --browser --python --docs ;; esac
if [ "$preset" = tidy ]; then exec scripts/build.sh tidy all -- -k 0; fi
scripts/build.sh "$preset" all all_verify_interface_header_sets
exec ctest --preset "$preset" "$@"
