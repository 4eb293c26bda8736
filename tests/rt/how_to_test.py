"""docs/how-to/run-on-linuxcnc.md followed command by command, by a user with an empty home folder, with an installed Trunnion.

    how_to_test.py BUILD_DIR SOURCE_DIR

What the page says in words is done as it says: LinuxCNC is switched on and homed, `start` is typed, the program is run. Exit status
77: not root, no package manager of Debian, or LinuxCNC runs."""
import json
import os
import pathlib
import pwd
import shutil
import subprocess
import sys
import tempfile
import time

LOCK = pathlib.Path(tempfile.gettempdir()) / 'linuxcnc.lock'
USER = 'lcnc'


def operate(what):
    """At a running LinuxCNC, as its user. `ready`: switches on and homes; a program: runs it. Prints where the joints came to."""
    import linuxcnc
    command, stat, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
    reached, said = [0.0] * 5, []

    def until(done):
        for _ in range(12000):
            stat.poll()
            for j in range(5):
                reached[j] = max(reached[j], abs(stat.joint[j]['output']))
            message = errors.poll()
            if message:
                said.append(message[1])
            if done():
                return
            time.sleep(0.005)
        raise TimeoutError(what)

    if what == 'ready':
        for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
            command.state(state)
            command.wait_complete()
        command.home(-1)
        until(lambda: all(stat.homed[:5]))
        command.mode(linuxcnc.MODE_MDI)
        command.wait_complete()
    else:
        command.mode(linuxcnc.MODE_AUTO)
        command.wait_complete()
        command.program_open(what)
        command.auto(linuxcnc.AUTO_RUN, 0)
        until(lambda: stat.interp_state != linuxcnc.INTERP_IDLE)
        until(lambda: stat.interp_state == linuxcnc.INTERP_IDLE and stat.inpos)
    print(json.dumps({'reached': reached, 'stands': [stat.joint[j]['output'] for j in range(5)], 'said': said}))


class Follower:
    def __init__(self, build, folder):
        self.folder, self.prefix, self.linuxcnc = folder, folder / 'prefix', None
        subprocess.run(['cmake', '--install', build, '--prefix', self.prefix], check=True, stdout=subprocess.DEVNULL)
        self.here = folder / 'home' / 'work'
        self.here.mkdir(parents=True)
        shutil.copy(__file__, folder / 'at_the_machine.py')
        subprocess.run(['chmod', 'a+rx', folder], check=True)
        subprocess.run(['chown', '-R', USER, folder / 'home'], check=True)
        self.environment = {'HOME': str(folder / 'home'), 'USER': USER, 'PATH': f'{self.prefix}/bin:/usr/bin:/bin:/usr/sbin', 'TERM': 'dumb'}

    def as_user(self, words, **more):
        return subprocess.Popen(['nice', '-n', '-10', 'runuser', '-u', USER, '--', 'env', '-i', *(f'{k}={v}' for k, v in self.environment.items()),
                                 *words], cwd=self.here, text=True, start_new_session=True, **more)

    def output(self, words, given=None):
        process = self.as_user(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        out, _ = process.communicate(given, timeout=120)
        assert process.returncode == 0, (words, process.returncode, out)
        return out

    def operate(self, what):
        out = json.loads(self.output(['/usr/bin/python3', str(self.folder / 'at_the_machine.py'), '--operate', what]).splitlines()[-1])
        assert not out['said'], out['said']
        return out

    def write(self, name, text):
        (self.here / name).write_text(text)

    def follow(self, command):
        print('$', command, flush=True)
        words = command.replace('/usr/local/', f'{self.prefix}/')
        if words.startswith('sudo '):
            words = words.removeprefix('sudo ').replace('apt install', 'apt-get install -y -qq')
            subprocess.run(words, shell=True, check=True, stdout=subprocess.DEVNULL, cwd=self.folder,
                           env={'PATH': '/usr/bin:/bin:/usr/sbin:/sbin', 'HOME': '/root', 'DEBIAN_FRONTEND': 'noninteractive'})
        elif words.startswith('linuxcnc '):
            self.start(words)
        elif words.startswith('trunnion play '):
            print(self.output(words.split(), 'start\n'))
            self.expect(self.operate('ready'), moved=False)
        else:
            self.output(['sh', '-c', words])

    def start(self, words):
        """LinuxCNC, until the next one is started; one whose queue is planned by `serve` runs the program."""
        self.stop()
        self.log = open(self.folder / 'linuxcnc.log', 'w')
        self.linuxcnc = self.as_user(words.split(), stdin=subprocess.PIPE, stdout=self.log, stderr=subprocess.STDOUT)
        time.sleep(6)
        self.operate('ready')
        if 'serve' in next(self.here.joinpath(words.split()[1]).parent.glob('*.hal')).read_text():
            self.expect(self.operate(str(self.here / 'part.ngc')), moved=True)

    def expect(self, found, moved):
        print(found)
        assert max(abs(value) for value in found['stands']) < 1e-5, found
        assert not moved or found['reached'][0] > 15 and found['reached'][4] > 25, found

    def stop(self):
        if not self.linuxcnc:
            return
        self.linuxcnc.stdin.close()  # its display that is none waits for Enter
        try:
            self.linuxcnc.wait(30)
        finally:
            subprocess.run(['pkill', '-KILL', '-s', str(self.linuxcnc.pid)])
            LOCK.unlink(missing_ok=True)
            self.linuxcnc = None


def main():
    if sys.argv[1] == '--operate':
        return operate(sys.argv[2])
    build, source = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    if os.getuid() != 0 or not shutil.which('apt-get') or LOCK.exists():
        return 77
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(source / 'tests' / 'docs'))
    from snippets_test import blocks_of
    try:
        pwd.getpwnam(USER)
    except KeyError:
        subprocess.run(['useradd', '-m', USER], check=True)
    for module in pathlib.Path('/usr/lib/linuxcnc/modules').glob('trunnion_tp.so'):
        module.unlink()
    folder = pathlib.Path(tempfile.mkdtemp(prefix='how-to-'))
    follower = Follower(build, folder)
    try:
        for block in blocks_of(source / 'docs' / 'how-to' / 'run-on-linuxcnc.md'):
            if block.name:
                follower.write(block.name, block.text())
            for line in [] if block.name else block.lines:
                if block.language == 'text':
                    follower.follow(line.strip())
                elif line.startswith('$ '):
                    follower.follow(line[2:])
    finally:
        follower.stop()
    shutil.rmtree(folder)


if __name__ == '__main__':
    sys.exit(main())
