#!/usr/bin/env bash
# From a bare Debian 12 machine to jerk-limited setpoints of a 5-axis program: installs what is missing, builds, plans the
# example, prints the summary, has the independent checker judge the setpoints, and writes the page that shows where the time goes.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install_dependencies.sh
scripts/build.sh release trunnion
out=build/demo
mkdir -p "$out"
example=examples/01_first_plan
build/release/apps/trunnion/trunnion plan "$example/blade.ngc" -m xyzac-trt --setup "$example/setup.toml" \
  -o "$out/setpoints.csv" --summary "$out/summary.json" --quiet
echo
build/release/apps/trunnion/trunnion check "$out/setpoints.csv" --against "$example/blade.ngc" -m xyzac-trt \
  --setup "$example/setup.toml" --quiet
echo
echo "setpoints: $out/setpoints.csv   summary: $out/summary.json"
# Built without Node.js there is no page, and the program says so.
build/release/apps/trunnion/trunnion report "$example/blade.ngc" -m xyzac-trt --setup "$example/setup.toml" --worth \
  -o "$out/report.html" --quiet && echo "page for a browser: $PWD/$out/report.html" || [ $? -eq 2 ]
