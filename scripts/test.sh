#!/usr/bin/env bash
# From a bare Debian 12 machine to the verdict of all tests: installs what is missing, builds, checks that every public header
# compiles alone, runs ctest.   scripts/test.sh [PRESET] [ctest option…]     preset: release (default), dev, asan, clang
set -euo pipefail
cd "$(dirname "$0")/.."
preset=release
case "${1:-}" in release|dev|asan|clang) preset=$1; shift ;; esac
if [ "$preset" = clang ]; then scripts/install_dependencies.sh --developer; else scripts/install_dependencies.sh; fi
scripts/build.sh "$preset" all all_verify_interface_header_sets
exec ctest --preset "$preset" "$@"
