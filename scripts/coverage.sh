#!/usr/bin/env bash
# Runs the default suite in the preset coverage and prints which share of its lines each room has run.
#   scripts/coverage.sh [ctest option…]      the whole, line by line: build/coverage/report/index.html
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install_dependencies.sh --developer
scripts/build.sh coverage all
find build/coverage -name '*.gcda' -delete
status=0
ctest --preset coverage --output-on-failure "$@" >&2 || status=$?
mkdir -p build/coverage/report
gcovr --root . --object-directory build/coverage --filter 'src/' --filter 'apps/' --gcov-ignore-parse-errors -j 2 \
  --json-summary build/coverage/report/summary.json --html-details build/coverage/report/index.html \
  build/coverage >&2
python3 - build/coverage/report/summary.json <<'PYTHON'
import collections, json, sys
rooms = collections.defaultdict(lambda: [0, 0])
for file in json.load(open(sys.argv[1]))['files']:
    parts = file['filename'].split('/')
    for room in ('/'.join(parts[:2]), 'all'):
        rooms[room][0] += file['line_covered']
        rooms[room][1] += file['line_total']
for room, (covered, total) in sorted(rooms.items(), key=lambda row: (row[0] == 'all', row[0])):
    print(f'{room:<20}{covered:>7} of {total:>6} lines {100 * covered / max(total, 1):6.1f} %')
PYTHON
exit "$status"
