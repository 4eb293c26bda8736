"""Runs the program on an input that must be refused: exit status 2, the expected code on stderr, no output file, nothing on stdout.

    reject_test.py TRUNNION FOLDER CODE WORD…      the words of `trunnion plan`, or of another command that they begin with"""
import pathlib
import subprocess
import sys
import tempfile


def command_line(words, out):
    """With every output that the command can write, into the folder `out`."""
    if words[0] in ('machine', 'controller', 'serve'):
        return words
    if words[:2] == ['surface', 'list']:
        return words
    if words[:2] == ['surface', 'plan']:
        return [*words, '-o', f'{out}/p.nc', '--summary', f'{out}/s.json']
    if words[:2] == ['surface', 'run']:
        return [*words, '-o', f'{out}/q.csv', '--summary', f'{out}/s.json']
    if words[0] in ('convert', 'smooth', 'deform'):
        return [*words, '-o', f'{out}/p.nc']
    if words[0] == 'play':
        return [*words, '-o', f'{out}/rows.csv']
    if words[0] == 'predict':
        return [*words, '--summary', f'{out}/s.json', '--samples', f'{out}/p.csv']
    if words[0] == 'report':
        return [*words, '-o', f'{out}/page.html']
    if words[0] == 'check':
        return [*words, '--summary', f'{out}/s.json']
    return ['plan', *words, '-o', f'{out}/q.csv', '--summary', f'{out}/s.json', '--path', f'{out}/path.csv', '--programmed',
            f'{out}/p.csv', '--events', f'{out}/e.csv']


def main():
    trunnion, folder, code = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([trunnion, *command_line(sys.argv[4:], out)], capture_output=True, text=True, cwd=folder,
                              timeout=60)
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
