#!/usr/bin/env bash
# Configures where needed and builds: scripts/build.sh PRESET [target…]. Seconds when nothing changed.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift
[ -f "build/$preset/build.ninja" ] || cmake --preset "$preset" >"/tmp/trunnion-configure-$$.log" 2>&1 ||
  { cat "/tmp/trunnion-configure-$$.log" >&2; exit 1; }
rm -f "/tmp/trunnion-configure-$$.log"
cmake --build "build/$preset" --target "${@:-all}" >&2
