"""What happens to a run may go wrong at any moment: each time the exit status says so, with a code, and every output file is either what
it was before or the whole new one.

    faults_test.py TRUNNION SOURCE CLOCK_JUMP [--only PART] [--times N] [--seed N]

CLOCK_JUMP: a library that makes the wall clock jump. PART: interrupted, killed, memory, disk, closed, input, clock. --times: how
many interruptions, and a tenth of it of what else is random; below 300 not every command is tried with little memory and with closed
streams."""
import argparse
import gzip
import json
import math
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

BEFORE = b'of the run before'
LIMIT_S = 120


class Job:
    """A command line with its outputs, run in a folder of its own, and what it leaves there when all goes well."""

    def __init__(self, trunnion, name, words, outputs=(), statuses=(0,)):
        self.name, self.outputs, self.statuses = name, outputs, statuses
        self.command = [str(word) for word in [trunnion, *words]]
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            done = self.run(folder)
            self.seconds = time.monotonic() - start
            if done.returncode not in statuses:
                sys.exit(f'{name}: status {done.returncode}, {done.stderr.decode()}')
            self.whole = {output: (pathlib.Path(folder) / output).read_bytes() for output in outputs}

    def run(self, folder, before=None, **options):
        return subprocess.run(self.command, cwd=folder, capture_output=True, timeout=LIMIT_S, preexec_fn=before, **options)

    def wrong_files(self, folder):
        """What lies in the folder and should not."""
        out = []
        for file in pathlib.Path(folder).iterdir():
            content = file.read_bytes()
            if file.name not in self.outputs:
                out.append(f'{file.name} is left')
            elif content != BEFORE and not self.is_whole(file.name, content):
                out.append(f'{file.name} is not whole')
        return out

    def is_whole(self, name, content):
        """Summaries and pages hold the times that the work took."""
        whole = self.whole[name]
        if name.endswith('.json'):
            try:
                return json.loads(content).keys() == json.loads(whole).keys()
            except ValueError:
                return False
        if name.endswith('.html'):
            return content[-200:] == whole[-200:] and abs(len(content) - len(whole)) < 1000
        return content == whole


class Faults:
    def __init__(self, options):
        self.options, self.wrong, self.told = options, [], {}
        self.random = random.Random(options.seed)
        source = pathlib.Path(options.source).resolve()
        examples, docs = source / 'examples', source / 'tests/docs'
        trunnion = pathlib.Path(options.trunnion).resolve()
        self.scratch = pathlib.Path(tempfile.mkdtemp())
        setpoints, program = self.scratch / 'setpoints.csv', self.scratch / 'waves.ngc'
        program.write_text(waves(options.blocks))
        part = [program, '-m', 'xyzac-trt', '--setup', examples / '01_first_plan/setup.toml', '-q']
        self.start_s = min(seconds_of(trunnion, '--version') for _ in range(3))

        def job(name, words, outputs=(), statuses=(0,)):
            return Job(trunnion, name, words, outputs, statuses)

        self.jobs = [
            job('plan', ['plan', *part, '-o', 'q.csv', '--summary', 's.json', '--path', 'path.csv', '--programmed', 'p.csv', '--events', 'e.csv'],
                ('q.csv', 's.json', 'path.csv', 'p.csv', 'e.csv')),
            job('plan to .npy and .gz', ['plan', *part, '-o', 'q.npy', '--path', 'path.csv.gz'], ('q.npy', 'path.csv.gz')),
            job('smooth', ['smooth', *part, '-o', 'smooth.ngc'], ('smooth.ngc',)),
            job('convert', ['convert', examples / '05_convert/rim.cls', '-m', 'trunnion-bc', '--setup', examples / '05_convert/setup.toml',
                            '--to', 'sinumerik', '-q', '-o', 'rim.mpf'], ('rim.mpf',)),
            job('predict', ['predict', *part, '-c', 'linuxcnc-2.9', '--summary', 'p.json', '--samples', 'samples.csv'],
                ('p.json', 'samples.csv'), (0, 1)),
            job('report', ['report', *part, '-c', 'linuxcnc-2.9', '-o', 'page.html'], ('page.html',), (0, 1)),
            job('surface plan', ['surface', 'plan', docs / 'hollow.toml', '--tool', 'ball 10mm', '--scallop', '200um', '--gouge-tolerance',
                                 '10um', '-o', 'passes.mpf'], ('passes.mpf',)),
            job('surface run', ['surface', 'run', docs / 'humped.toml', '--tool', 'flat 12mm', *part[1:], '--period', '10ms', '-o',
                                'surface.csv', '--summary', 'run.json'], ('surface.csv', 'run.json'), (0, 1)),
            job('machine export', ['machine', 'export', 'xyzac-trt', '--linuxcnc'],
                tuple(f'xyzac-trt.{extension}' for extension in ('ini', 'hal', 'tbl', 'var'))),
        ]
        subprocess.run([trunnion, 'plan', *part, '-o', setpoints], check=True, capture_output=True)
        subprocess.run([trunnion, 'machine', 'export', 'xyzac-trt', '--linuxcnc', '-o', self.scratch], check=True, capture_output=True)
        self.jobs += [
            job('check', ['check', setpoints, '--against', *part, '--summary', 'v.json'], ('v.json',), (0, 1)),
            job('deform', ['deform', examples / '07_flank/blade.cls', '-m', 'ucp710', '--setup', examples / '07_flank/setup.toml', '--flank',
                           examples / '07_flank/blade.csv', '--from-height', '2mm', '--to-height', '27mm', '--to', 'sinumerik', '-q', '-o',
                           'blade.mpf'], ('blade.mpf',), (0, 1)),
            job('surface list', ['surface', 'list', docs / 'hollow.toml']),
            job('machine show', ['machine', 'show', 'ucp710']),
            job('machine import', ['machine', 'import', self.scratch / 'xyzac-trt.ini', '-o', 'm.toml'], ('m.toml',)),
            job('controller list', ['controller', 'list']),
        ]
        self.by_name = {job.name: job for job in self.jobs}

    def times(self):
        return max(1, self.options.times // 10)

    def some_jobs(self):
        """All of them where much is asked for."""
        return self.jobs if self.options.times >= 300 else self.random.sample(self.jobs, 6)

    def count(self, what):
        self.told[what] = self.told.get(what, 0) + 1

    def judge(self, job, what, folder, status, stderr, allowed):
        """allowed: statuses, each with the code that stderr must say then, or None."""
        found = job.wrong_files(folder)
        if status not in allowed:
            found.append(f'status {status}')
        elif allowed[status] and f'error {allowed[status]}'.encode() not in stderr:
            found.append(f'status {status} without {allowed[status]}')
        if found:
            self.wrong.append(f'{job.name}, {what}: {", ".join(found)}; {stderr.decode(errors="replace").strip()[-300:]}')
        return not found

    def folder_of(self, job, with_files):
        folder = tempfile.mkdtemp(dir=self.scratch)
        for output in job.outputs if with_files else ():
            (pathlib.Path(folder) / output).write_bytes(BEFORE)
        return folder

    def stopped(self, job, by, with_files):
        """Runs it and sends the signal at a random moment; what came of it."""
        folder = self.folder_of(job, with_files)
        run = subprocess.Popen(job.command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        begun = self.random.random() < 0.95
        while begun and not answers(run.pid, signal.SIGINT) and run.poll() is None:
            time.sleep(0.001)
        time.sleep(self.random.uniform(0, max(job.seconds - self.start_s, 0.01)))
        run.send_signal(by)
        _, stderr = run.communicate(timeout=LIMIT_S)
        return folder, run.returncode, stderr

    # ---- the parts

    def interrupted(self):
        """SIGINT. Status −2: before the program proper had begun."""
        jobs = [job for job in self.jobs if job.seconds > 0.02]
        for n in range(self.options.times):
            job = jobs[n % len(jobs)]
            folder, status, stderr = self.stopped(job, signal.SIGINT, n % 2)
            good = self.judge(job, 'interrupted', folder, status, stderr, {130: 'PIPE0002', -2: None} | dict.fromkeys(job.statuses))
            self.count('interruptions clean' if good else 'interruptions not clean')
            self.count({130: 'interruptions with status 130', -2: 'interruptions before the program began'}.get(status, 'interruptions too late'))
            shutil.rmtree(folder)

    def killed(self):
        """As by a power cut; the next run must not be disturbed by what is left."""
        jobs = [job for job in self.jobs if job.outputs]
        for n in range(self.options.times if self.options.only == 'killed' else 3 * self.times()):
            job = jobs[n % len(jobs)]
            folder, status, stderr = self.stopped(job, signal.SIGKILL, n % 2)
            # Between getting a name and taking its place a file, whole by then, has its temporary one.
            for left in pathlib.Path(folder).glob('*.part'):
                name = '.'.join(left.name.split('.')[:-2])
                self.count('temporary names left by kills')
                if not job.is_whole(name, left.read_bytes()):
                    self.wrong.append(f'{job.name}, killed: {left.name} is not whole')
                left.unlink()
            good = self.judge(job, 'killed', folder, status, stderr, {-9: None} | dict.fromkeys(job.statuses))
            again = job.run(folder)
            good = good and self.judge(job, 'after being killed', folder, again.returncode, again.stderr, dict.fromkeys(job.statuses))
            self.count('kills clean' if good else 'kills not clean')
            shutil.rmtree(folder)

    def least_memory(self):
        """Bytes of addresses with which the program begins at all."""
        def begins(size):
            done = subprocess.run([self.jobs[0].command[0], '--version'], capture_output=True, preexec_fn=limit_memory(size))
            return done.returncode == 0
        low, high = 1 << 20, 1 << 33
        while high - low > 1 << 20:
            middle = (low + high) // 2
            low, high = (low, middle) if begins(middle) else (middle, high)
        return high

    def memory(self):
        least = self.least_memory()
        for job in self.some_jobs():
            enough = least + (1 << 20)
            while self.memory_run(job, enough) != 'enough' and enough < 1 << 33:
                enough = least + 2 * (enough - least)
            for _ in range(1 + self.times()):
                self.memory_run(job, self.random.randrange(least, enough))

    def memory_run(self, job, size):
        folder = self.folder_of(job, True)
        done = job.run(folder, limit_memory(size))
        if done.returncode == -6 and b'Standard_OutOfMemory' in done.stderr:
            self.count('runs in which a library did not load')
            shutil.rmtree(folder)
            return 'short'
        # Also libraries that do not look whether they got memory.
        shorts = {3: 'PIPE000', 2: ''}
        self.judge(job, f'with {size >> 10} KB', folder, done.returncode, done.stderr, shorts | dict.fromkeys(job.statuses))
        enough = done.returncode in job.statuses
        self.count('runs with enough memory' if enough else 'runs short of memory')
        shutil.rmtree(folder)
        return 'enough' if enough else 'short'

    def disk(self):
        for job in self.jobs:
            if not any(len(content) > 64 for content in job.whole.values()):
                continue
            folder = self.folder_of(job, True)
            done = job.run(folder, no_room)
            self.judge(job, 'no room for files', folder, done.returncode, done.stderr, {2: 'FILE0202'})
            self.count('runs on a full disk')
        self.full_file_system()

    def full_file_system(self):
        """A real one, of 64 KB, where this may be mounted."""
        job = self.by_name['plan']
        with tempfile.TemporaryDirectory() as folder:
            words = ['unshare', '-m', 'sh', '-c', 'mount -t tmpfs -o size=64k none . && cd "$PWD" && "$@"; status=$?; ls >&2; exit $status', 'sh']
            done = subprocess.run([*words, *job.command], cwd=folder, capture_output=True, timeout=LIMIT_S)
            if os.getuid() != 0 or b'mount:' in done.stderr or b'unshare:' in done.stderr:
                return
            lines = done.stderr.decode().splitlines()
            if done.returncode != 2 or not any('error FILE0202' in line for line in lines) or any(line in job.outputs for line in lines):
                self.wrong.append(f'a full file system: status {done.returncode}, {lines}')
            self.count('runs on a full file system')

    def closed(self):
        """Standard streams that are full, closed, or whose reader went away."""
        for job in self.some_jobs():
            printed = bool(job.run(self.folder_of(job, False)).stdout)
            folder = self.folder_of(job, True)
            with open('/dev/full', 'w') as full:
                done = subprocess.run(job.command, cwd=folder, stdout=full, stderr=subprocess.PIPE, timeout=LIMIT_S)
            self.judge(job, 'stdout full', folder, done.returncode, done.stderr, {2: 'FILE0202'} if printed else dict.fromkeys(job.statuses))
            for streams in ((1,), (0, 1), (0, 1, 2)):
                folder = self.folder_of(job, True)
                done = job.run(folder, lambda: [os.close(stream) for stream in streams])
                self.judge(job, f'streams {streams} closed', folder, done.returncode, done.stderr, dict.fromkeys(job.statuses))
            folder = self.folder_of(job, True)
            reading, writing = os.pipe()
            os.close(reading)
            done = subprocess.run(job.command, cwd=folder, stdout=writing, stderr=subprocess.PIPE, timeout=LIMIT_S)
            os.close(writing)
            self.judge(job, 'nobody reads', folder, done.returncode, done.stderr,
                       {-signal.SIGPIPE: None, 2: 'FILE0202'} if printed else dict.fromkeys(job.statuses))
            self.count('commands with streams full or closed')

    def input(self):
        """Programs that end, or become shorter, while they are read."""
        lines = [f'G1 X{k % 700 / 10} Y{k % 300 / 10} Z{k % 7} A{k % 9} C{k % 11}' for k in range(200_000)]
        text = '\n'.join(['G21 G90 G94 F5000', *lines]).encode()
        job = self.by_name['plan']
        program = self.scratch / 'long.ngc'
        for n in range(2 + self.times()):
            program.write_bytes(text)
            folder = self.folder_of(job, True)
            run = subprocess.Popen([job.command[0], 'convert', program, '-q', '-o', 'rim.mpf', '--to', 'sinumerik', '-m', 'xyzac-trt'],
                                   cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            time.sleep(self.random.uniform(0, 0.5))
            os.truncate(program, self.random.choice([0, 4096 * self.random.randrange(1000), self.random.randrange(len(text))]))
            _, stderr = run.communicate(timeout=LIMIT_S)
            coded = b'error ' in stderr
            if run.returncode not in (0, 2) or (run.returncode == 2 and not coded):
                self.wrong.append(f'a program that becomes shorter: status {run.returncode}, {stderr.decode().strip()[-300:]}')
            self.count('programs that became shorter: refused' if run.returncode == 2 else 'programs that became shorter: read before')
        packed = gzip.compress(text)
        short = self.scratch / 'short.ngc.gz'
        short.write_bytes(packed[:len(packed) // 2])
        pipe = self.scratch / 'pipe.ngc'
        os.mkfifo(pipe)
        for file, word in ((short, 'packed, cut'), (pipe, 'a pipe')):
            folder = self.folder_of(job, True)
            done = subprocess.run(['sh', '-c', '(printf "G21" > "$0") & exec "$@"' if file == pipe else 'exec "$@"', file, job.command[0], 'plan', file,
                                   *job.command[3:]], cwd=folder, capture_output=True, timeout=LIMIT_S)
            self.judge(job, word, folder, done.returncode, done.stderr, {2: 'NC'})
            self.count('inputs refused')

    def clock(self):
        """The wall clock jumps by hours and years with every look at it: nothing that is written changes."""
        for name in ('plan', 'smooth', 'surface run', 'predict'):
            job = self.by_name[name]
            folder = self.folder_of(job, False)
            done = job.run(folder, env=dict(os.environ, LD_PRELOAD=self.options.clock_jump))
            self.judge(job, 'clock jumps', folder, done.returncode, done.stderr, dict.fromkeys(job.statuses))
            if sorted(os.listdir(folder)) != sorted(job.outputs):
                self.wrong.append(f'{name}, clock jumps: {os.listdir(folder)}')
            self.count('runs with a clock that jumps')


def waves(blocks):
    """A program of five axes that goes to and fro."""
    lines = [f'X{20 * math.sin(0.11 * k):.4f} Y{0.02 * k:.4f} Z{2 * math.cos(0.3 * k):.4f} A{-10 + 8 * math.sin(0.07 * k):.4f} C{15 * math.cos(0.05 * k):.4f}'
             for k in range(blocks)]
    return '\n'.join(['G21 G90 G94', f'G0 {lines[0]}', f'G1 F900 {lines[1]}', *lines[2:], 'M2', ''])


def answers(process, number):
    """Whether the process has a handler for the signal: the program proper has begun."""
    try:
        status = pathlib.Path(f'/proc/{process}/status').read_text()
    except OSError:
        return False
    caught = [line.split()[1] for line in status.splitlines() if line.startswith('SigCgt')]
    return bool(caught) and int(caught[0], 16) >> (number - 1) & 1 == 1


def seconds_of(*command):
    start = time.monotonic()
    subprocess.run(command, check=True, capture_output=True)
    return time.monotonic() - start


def limit_memory(size):
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size))


def no_room():
    """Every file may hold no more than 64 bytes; writing on fails as on a full disk."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('trunnion')
    parser.add_argument('source')
    parser.add_argument('clock_jump')
    parts = ['interrupted', 'killed', 'memory', 'disk', 'closed', 'input', 'clock']
    parser.add_argument('--only', choices=parts)
    parser.add_argument('--times', type=int, default=30)
    parser.add_argument('--blocks', type=int, default=60, help='of the program that most commands work on')
    parser.add_argument('--seed', type=int, default=random.randrange(1 << 30))
    options = parser.parse_args()
    print(f'seed {options.seed}')
    faults = Faults(options)
    try:
        for part in [options.only] if options.only else parts:
            start = time.monotonic()
            getattr(faults, part)()
            print(f'{part}: {time.monotonic() - start:.1f} s')
    finally:
        shutil.rmtree(faults.scratch, ignore_errors=True)
    for what, count in faults.told.items():
        print(f'{count} {what}')
    sys.exit('\n'.join(faults.wrong) or 0)


main()
