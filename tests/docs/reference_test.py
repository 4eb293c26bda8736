"""The reference is complete: the page of the command line is what --help says, the pages of files have every key that is
read, the page of summaries every key that is written, and none that does not exist.

    reference_test.py SOURCE_DIR TRUNNION"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

source, trunnion = (pathlib.Path(word).resolve() for word in sys.argv[1:])
reference = source / 'docs/reference'
faults = []


def told_in(page):
    return set(re.findall(r'`([\w.]+)`', (reference / page).read_text()))


def told_in_tables(page):
    """Keys in first columns."""
    cells = re.findall(r'^\| (`[^|]*) \|', (reference / page).read_text(), re.M)
    return {key for cell in cells for key in re.findall(r'`([a-z_]+)`', cell)}


def compare(page, existing, told):
    for key in sorted(existing - told_in(page)):
        faults.append(f'{page} does not have {key}')
    for key in sorted(told - existing):
        faults.append(f'{page} has {key}, which does not exist')


def keys_allowed(*files):
    """What the reader of a file refuses everything but."""
    text = ''.join((source / 'src' / file).read_text() for file in files)
    lists = re.findall(r'allow_only\([^{;]*\{([^}]*)\}\)', text)
    return {key for one in lists for key in re.findall(r'"(\w+)"', one)}


def compare_files():
    for page, file in (('machine-file.md', 'files/machine_file.cpp'), ('setup-file.md', 'files/setup_file.cpp')):
        compare(page, keys_allowed(file), told_in_tables(page))
    facts = (source / 'src/motion/controller.cpp').read_text()
    parameters = set(re.findall(r'(?<=[\s{])\{"([a-z_]+)",\s+"', facts)) | {'max_velocity', 'max_acceleration'}
    compare('controller-file.md', keys_allowed('files/controller_file.cpp') | parameters, told_in_tables('controller-file.md'))


def keys_of(node):
    """All keys of a summary; of axes, whose keys are letters, what each of them has."""
    if isinstance(node, list):
        return set().union(*map(keys_of, node))
    if not isinstance(node, dict):
        return set()
    found = {key for key in node if not re.fullmatch('[A-Z]', key)}
    return found.union(*map(keys_of, node.values()))


def compare_summaries():
    example = source / 'examples/01_first_plan'
    machine = ['-m', 'xyzac-trt', '--setup', example / 'setup.toml', '-q']
    job = [example / 'blade.ngc', *machine]
    with tempfile.TemporaryDirectory() as folder:
        def summary_of(*words):
            file = pathlib.Path(folder) / 'summary.json'
            subprocess.run([trunnion, *words, '--summary', file], check=True, capture_output=True, cwd=folder)
            return keys_of(json.loads(file.read_text()))

        written = summary_of('plan', *job, '--worth', '-o', 'setpoints.csv')
        written |= summary_of('check', 'setpoints.csv', '--against', *job)
        written |= summary_of('predict', *job, '-c', 'linuxcnc-2.9', '--against', 'ideal')
        written |= summary_of('surface', 'plan', source / 'tests/docs/hollow.toml', '--tool', 'ball 10mm', '--scallop', '50um',
                              '--gouge-tolerance', '10um', '--curves', 'splines', '--check', '-o', 'passes.mpf')
        written |= summary_of('surface', 'run', source / 'tests/docs/humped.toml', '--tool', 'flat 12mm', *machine, '--period',
                              '10ms', '-o', 'surface.csv')
    in_sources = set()
    for room in ('base', 'verify', 'pipeline'):
        for file in (source / 'src' / room).glob('*.cpp'):
            in_sources |= set(re.findall(r'"([a-z_0-9]+)"', file.read_text()))
    header = (source / 'src/pipeline/detail/diagnostics_json.hpp').read_text()
    in_sources |= set(re.findall(r'\{"([a-z_]+)", ', header))
    for key in sorted(written - told_in('summary.md')):
        faults.append(f'summary.md does not have {key}')
    # What is written only where something is wrong is in the sources alone; names of axes' excesses are put together.
    for key in sorted(told_in_tables('summary.md') - written - in_sources - {'range_excess_mm', 'range_excess_deg'}):
        faults.append(f'summary.md has {key}, which does not exist')


compare_files()
compare_summaries()
page = subprocess.run([source / 'scripts/command_line_reference.py', trunnion, '--check'], capture_output=True, text=True)
if page.returncode:
    faults.append(page.stderr.strip())
sys.exit('\n'.join(faults) or 0)
