"""Runs two programs on the real LinuxCNC and on the model of it: they agree to the servo period.

    linuxcnc_test.py MODEL SHARED SOURCE

Exit status 77: LinuxCNC or the shared folder is not there, or the control did not keep up with its own clock: of its
runs no two are alike, so that there is nothing to agree with."""
import json
import pathlib
import subprocess
import sys
import tempfile

model, shared, source = sys.argv[1:4]
with tempfile.TemporaryDirectory() as folder:
    result = pathlib.Path(folder) / 'rows.json'
    done = subprocess.run(['/usr/bin/python3', f'{source}/scripts/compare_linuxcnc.py', '--model', model, '--shared', shared, '--only', 'corners-g61',
                           'table-g64p', '--json', result], capture_output=True, text=True)
    print(done.stdout + done.stderr)
    if done.returncode != 0:
        sys.exit(done.returncode)
    rows = json.loads(result.read_text())
wrong = [row for row in rows if row['periods'] != 0 or row['position_mm'] > 1e-6 or row['joint_mm'] > 1e-6 or row['velocity'] > 1e-3
         or row['acceleration'] > 1e-3]
if wrong and not any(row['repeated'] for row in wrong):
    print(f'skipped: no two runs of the control are alike: {wrong}')
    sys.exit(77)
if wrong or len(rows) != 2:
    sys.exit(f'wrong: {wrong}')
