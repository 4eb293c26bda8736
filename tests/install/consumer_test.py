"""Installs the build into a fresh folder and uses it from outside: find_package, the whole way, one room alone, and the
program with the machines it ships.

    consumer_test.py BUILD_DIR SOURCE_DIR CMAKE CXX_COMPILER CXX_FLAGS VERSION"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile


def run(*command, cwd):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, cwd=cwd)
    if done.returncode != 0:
        sys.exit(f'{" ".join(map(str, command))}\nended with {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout


def main():
    build, source, cmake, compiler, flags, version = sys.argv[1:]
    work = pathlib.Path(build) / 'tests/install/work'
    shutil.rmtree(work, ignore_errors=True)
    prefix, consumer = work / 'prefix', work / 'consumer'
    run(cmake, '--install', build, '--prefix', prefix, cwd=build)

    # Only headers and libraries of the prefix: none may point back into the tree that was built.
    for file in prefix.rglob('*.cmake'):
        for tree in (source, build):
            if f'{tree}/src' in file.read_text() or f'{tree}/data' in file.read_text():
                sys.exit(f'{file} points into {tree}')

    here = pathlib.Path(__file__).parent
    run(cmake, '-G', 'Ninja', '-S', here, '-B', consumer, f'-DCMAKE_PREFIX_PATH={prefix}', f'-DCMAKE_CXX_COMPILER={compiler}',
        f'-DCMAKE_CXX_FLAGS={flags}', cwd=work)
    run(cmake, '--build', consumer, cwd=work)

    machines = prefix / 'share/trunnion/machines'
    said = run(consumer / 'plan', machines / 'xyzac-trt.toml', cwd=work)
    cycle_time_s = float(re.fullmatch(r'cycle time ([\d.]+) s, (\d+) setpoints\n', said)[1])
    if not 1 < cycle_time_s < 60:
        sys.exit(f'a cycle time of {cycle_time_s} s is out of the question')
    if run(consumer / 'kinematics', cwd=work) != 'tip 1 2 10\n':
        sys.exit('one room alone gives another tip')

    # The program from another folder; its machines are the installed ones, wherever the prefix was moved to.
    moved = work / 'moved'
    prefix.rename(moved)
    trunnion = moved / 'bin/trunnion'
    with tempfile.TemporaryDirectory() as elsewhere:
        if run(trunnion, '--version', cwd=elsewhere).split()[-1] != version:
            sys.exit('another version')
        names = {line.split()[0] for line in run(trunnion, 'machine', 'list', cwd=elsewhere).splitlines()}
        wanted = {file.stem for file in (pathlib.Path(source) / 'data/machines').glob('*.toml')}
        if names != wanted:
            sys.exit(f'machine list says {sorted(names)}, shipped are {sorted(wanted)}')
        shown = run(trunnion, 'machine', 'show', 'xyzac-trt', cwd=elsewhere)
        if str(moved) not in shown:
            sys.exit(f'not the installed machine:\n{shown}')
    print(said, end='')
    shutil.rmtree(work)


main()
