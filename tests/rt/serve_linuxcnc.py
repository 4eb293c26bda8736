"""LinuxCNC's queue, planned by `trunnion serve`, on the real LinuxCNC: what an operator does, and a planner that is killed.

    serve_linuxcnc.py TRUNNION SOURCE_DIR SHARED_DIR [--times N] [SCENARIO …]

Each scenario (serve_scenarios.py) gets a LinuxCNC of its own. Exit status 77: LinuxCNC or its development package is not there,
or LinuxCNC runs; 1: one failed."""
import argparse
import importlib.util
import json
import pathlib
import shutil
import sys
import tomllib
import traceback

HERE = pathlib.Path(__file__).resolve().parent
FILES = ('serve_linuxcnc.py', 'serve_scenarios.py', 'operator_panel.py')
LONGEST_S = 240
sys.dont_write_bytecode = True


def module_at(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def limits_of(machine):
    """Velocity, acceleration and jerk of the axes: linear ones by letter, then rotary ones, in mm and deg."""
    axes = tomllib.loads(pathlib.Path(machine).read_text())['axes']
    return [[float(axes[letter]['max_' + what].split()[0]) for what in ('velocity', 'acceleration', 'jerk')]
            for letter in sorted(axes, key='XYZABC'.index)]


def operate(folder, name):
    """As LinuxCNC's user interface, inside it."""
    import numpy
    import operator_panel
    import serve_scenarios
    wanted = json.loads((folder / 'wanted.json').read_text())
    panel, failed = None, None
    try:
        panel = operator_panel.Panel(folder, wanted['period_s'], numpy.array(wanted['limits']))
        panel.trunnion = [str(folder.parent / 'trunnion'), 'serve', '--linuxcnc', '-m', wanted['machine']]
        getattr(serve_scenarios, name)(panel)
    except Exception:
        failed = traceback.format_exc()
    result = {'failed': failed}
    if panel:
        panel.look()
        numpy.save(folder / 'rows.npy', numpy.array(panel.recorded, dtype=float))
        result.update(said=panel.said, notes=panel.notes, periods=len(panel.recorded), lost=panel.record.num_overruns)
        panel.switch_off()
    (folder / 'result.json').write_text(json.dumps(result))


class Runs:
    def __init__(self, trunnion, source, shared):
        self.compare = module_at(pathlib.Path(source).resolve() / 'linuxcnc' / 'compare.py')
        if self.compare.absent() or self.compare.LOCK.exists():
            sys.exit(77)
        self.source, self.shared = pathlib.Path(source).resolve(), pathlib.Path(shared)
        self.folder, self.trunnion, self.machine = self.compare.prepare(trunnion, self.shared)

    def run(self, name, scenario):
        """What it noted; None: it failed."""
        folder = self.folder / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        for file in FILES:
            shutil.copy(HERE / file, folder)
        machine = self.machine if scenario.machine == 'peer-trunnion' else shutil.copy(
            self.source / 'data' / 'machines' / f'{scenario.machine}.toml', folder.parent)
        for case in ('sine-10k', 'gentle-0.5'):
            shutil.copy(self.shared / 'data' / 'cases' / f'{case}.ngc', folder)
        ini = self.compare.configure(folder, self.trunnion, machine, 'Trunnion', [folder / FILES[0], '--operate', folder, name],
                                     f'{1e3 * scenario.period_s} ms')
        next(folder.glob('*.hal')).open('a').write(scenario.hal)
        wanted = {'period_s': scenario.period_s, 'limits': limits_of(machine), 'machine': str(machine)}
        (folder / 'wanted.json').write_text(json.dumps(wanted))
        result = self.compare.run_linuxcnc(folder, ini, LONGEST_S)
        good = not result['failed'] and result['lost'] == 0
        print(name, 'good' if good else f'FAILED {result["failed"]}', f'{result.get("periods", 0)} periods;',
              '; '.join(result.get('notes', [])), *result.get('said', []), sep=' ', flush=True)
        return good


def main():
    if sys.argv[1:2] == ['--operate']:
        return operate(pathlib.Path(sys.argv[2]), sys.argv[3])
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ('trunnion', 'source', 'shared'):
        words.add_argument(name)
    words.add_argument('scenario', nargs='*')
    words.add_argument('--times', type=int, default=1)
    args = words.parse_intermixed_args()
    scenarios = module_at(HERE / 'serve_scenarios.py').SCENARIOS
    runs = Runs(args.trunnion, args.source, args.shared)
    failed = [name for _ in range(args.times) for name, scenario in scenarios.items()
              if name in (args.scenario or scenarios) and not runs.run(name, scenario)]
    if not failed:
        shutil.rmtree(runs.folder, ignore_errors=True)
    print(f'failed: {failed}, see {runs.folder}' if failed else 'all good')
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
