"""Outputs that cannot be written: exit status 2, the code on stderr, nothing half-written, and what was there before stays as it was.

    output_test.py TRUNNION FOLDER"""
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile

OPTIONS = {'-o': 'q.csv', '--summary': 's.json', '--path': 'path.csv', '--programmed': 'p.csv', '--events': 'e.csv'}


def disk_is_full():
    """Every file that the program writes may hold no more than 64 bytes; writing on fails as on a full disk."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64))


def main():
    trunnion, inputs = sys.argv[1], pathlib.Path(sys.argv[2])
    wrong = []

    def refused(what, code, options, out, left, before=None):
        done = subprocess.run([trunnion, 'plan', 'good.ngc', '-m', 'good.toml', '-q', *map(str, options)], capture_output=True,
                              text=True, cwd=inputs, timeout=60, preexec_fn=before)
        found = sorted(str(f.relative_to(out)) for f in out.rglob('*'))
        if done.returncode != 2 or f'error {code}:' not in done.stderr or found != sorted(left):
            wrong.append(f'{what}: status {done.returncode}, {done.stderr.strip() or "nothing said"}, files {found}')

    for option, name in OPTIONS.items():
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            refused(f'{option} in a folder that is not there', 'FILE0201', [option, out / 'nowhere' / name], out, [])
            refused(f'{option} in a folder where nothing can be created', 'FILE0201', [option, f'/proc/{name}'], out, [])
            (out / name).mkdir()
            (out / name / 'kept').touch()
            refused(f'{option} onto a folder', 'FILE0201', [option, out / name], out, [name, f'{name}/kept'])
        if option == '--events':
            continue  # one line: fits on any disk
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            refused(f'{option} on a full disk', 'FILE0202', [option, out / name], out, [], disk_is_full)
            (out / name).write_text('of the run before')
            refused(f'{option} on a full disk, over a file', 'FILE0202', [option, out / name], out, [name], disk_is_full)
            if (out / name).read_text() != 'of the run before':
                wrong.append(f'{option}: the file of the run before is gone')
    for name in ('q.csv.gz', 'q.npy'):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            refused(f'-o {name} on a full disk', 'FILE0202', ['-o', out / name], out, [], disk_is_full)
            refused(f'-o {name} in a folder that is not there', 'FILE0201', ['-o', out / 'nowhere' / name], out, [])
    if wrong:
        sys.exit('\n'.join(wrong))


main()
