"""Runs the program on an input that must be refused: exit status 2, the expected code on stderr, no output file, nothing on stdout.

    reject_test.py TRUNNION FOLDER CODE PROGRAM [option…]      `OUT` in an option stands for a fresh output file"""
import pathlib
import subprocess
import sys
import tempfile


def main():
    trunnion, folder, code = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as out:
        arguments = [trunnion, 'plan', sys.argv[4], *sys.argv[5:], '-o', f'{out}/q.csv', '--summary', f'{out}/s.json']
        done = subprocess.run(arguments, capture_output=True, text=True, cwd=folder, timeout=60)
        left = [f.name for f in pathlib.Path(out).iterdir()]
    wrong = []
    if done.returncode != 2:
        wrong.append(f'exit status {done.returncode}, not 2')
    if f'error {code}:' not in done.stderr:
        wrong.append(f'no {code}')
    if left:
        wrong.append(f'left behind: {left}')
    if done.stdout:
        wrong.append('something on stdout')
    print(done.stderr)
    if wrong:
        sys.exit('; '.join(wrong))


main()
