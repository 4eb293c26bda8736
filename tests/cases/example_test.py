"""Plans an example with a shipped machine and has `trunnion check` judge it: example_test.py TRUNNION PROGRAM SETUP MACHINE"""
import pathlib, subprocess, sys, tempfile

trunnion, program, setup, machine = sys.argv[1:]
with tempfile.TemporaryDirectory() as folder:
    setpoints = pathlib.Path(folder) / 'setpoints.csv'
    common = ['-m', machine, '--setup', setup, '--quiet']
    for command in (['plan', program, '-o', setpoints], ['check', setpoints, '--against', program]):
        done = subprocess.run([trunnion, *command, *common], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f'{command[0]} ends with {done.returncode}\n{done.stdout}{done.stderr}')
