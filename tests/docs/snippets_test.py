"""Carries out what a page of documentation shows.

    snippets_test.py PAGE SOURCE_DIR TRUNNION PROGRAMS_DIR     PROGRAMS_DIR: where the build put the page's C++ programs
    snippets_test.py --extract NAME PAGE                       prints the block that is to be the file NAME

A page runs in a fresh folder that has the examples and data of the source tree, with `trunnion` on the path:

    ```console      lines behind `$ ` are commands; the lines below one are what it prints, where the page shows any
    ```sh, ```python  carried out as a whole
    ```LANG NAME    becomes the file NAME: toml has to parse, NAME.cpp is a program that the build made
    indented lines that begin with `trunnion ` or `sed `   carried out, with stand-ins for `part.ngc` and its like

Every command has to end with status 0. In what is printed `…` stands for anything, alone in a line for any lines; numbers agree to
3 %. Commands that build or install are left to the scripts themselves: here they only have to be there."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

SHARE = 0.03
STAND_INS = {'part.ngc': 'examples/01_first_plan/blade.ngc', 'vice.toml': 'examples/01_first_plan/setup.toml',
             'part.cls': 'examples/05_convert/rim.cls', 'blade.cls': 'examples/07_flank/blade.cls',
             'blade.csv': 'examples/07_flank/blade.csv', 'blade.toml': 'examples/07_flank/setup.toml',
             'hills.toml': 'tests/docs/hollow.toml', 'dome.toml': 'tests/docs/humped.toml',
             'part.step': 'tests/unit/surfacing/faces/plate_with_hole.step'}
BUILDS = re.compile(r'(?:\S+=\S+ )*(scripts/\S+|cmake |ctest |sudo |git |build/)')
NUMBER = re.compile(r'[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?')


class Block:
    def __init__(self, line, info, lines):
        self.line, self.lines = line, lines
        self.language, _, self.name = info.partition(' ')

    def text(self):
        return ''.join(f'{line}\n' for line in self.lines)


def blocks_of(page):
    """Fenced blocks, and indented commands as blocks of sh."""
    out, fence = [], None
    for number, line in enumerate(page.read_text().splitlines(), 1):
        stripped = line.strip()
        if fence is None and stripped.startswith('```'):
            fence = Block(number, stripped[3:].strip(), [])
        elif fence is not None and stripped == '```':
            out.append(fence)
            fence = None
        elif fence is not None:
            fence.lines.append(line)
        elif re.match(r'    (trunnion|sed) ', line):
            out.append(Block(number, 'sh', [stripped]))
    if fence is not None:
        sys.exit(f'{page}:{fence.line}: the block does not end')
    return out


def commands_of(lines):
    """Of a console block: (command, lines it prints), backslashes joined."""
    out = []
    for line in lines:
        if line.startswith('$ '):
            out.append([line[2:], []])
        elif out and out[-1][0].endswith('\\') and not out[-1][1]:
            out[-1][0] = out[-1][0][:-1] + line.strip()
        elif out:
            out[-1][1].append(line)
        else:
            raise ValueError(f'output before the first command: {line}')
    return out


def line_agrees(shown, printed):
    """One line: the words between numbers alike, whatever the blanks; numbers close."""
    def pattern(words):
        parts = [r'\s+'.join(re.escape(word) for word in re.split(r'\s+', part)) for part in words.split('…')]
        return '.*?'.join(parts)

    numbers = [float(number) for number in NUMBER.findall(shown)]
    expression = f'({NUMBER.pattern})'.join(pattern(words) for words in NUMBER.split(shown.strip()))
    found = re.fullmatch(expression, printed.strip())
    return found is not None and all(abs(float(said) - number) <= SHARE * abs(number) + 1e-9
                                     for said, number in zip(found.groups(), numbers))


def output_agrees(shown, printed):
    """All lines in order; `…` alone in a line: any number of lines."""
    if not shown:
        return not printed
    if shown[0].strip() == '…':
        return any(output_agrees(shown[1:], printed[i:]) for i in range(len(printed) + 1))
    return bool(printed) and line_agrees(shown[0], printed[0]) and output_agrees(shown[1:], printed[1:])


class Page:
    def __init__(self, page, source, trunnion, programs, folder):
        self.page, self.source, self.folder, self.here = page, source, folder, folder
        self.programs = programs
        self.environment = dict(os.environ, PATH=f'{trunnion.parent}:{os.environ["PATH"]}')
        for part in ('examples', 'data'):
            shutil.copytree(source / part, folder / part)
        for name, stand_in in STAND_INS.items():
            shutil.copy(source / stand_in, folder / name)
        if page.name == 'README.md' and page.parent.parent.name == 'examples':
            self.here = folder / 'examples' / page.parent.name

    def fail(self, block, text):
        sys.exit(f'{self.page}:{block.line}: {text}')

    def run(self, block, command):
        """A command where the one before left the shell; what it prints."""
        build = BUILDS.match(command)
        if build:
            script = build[1].strip()
            if script.startswith('scripts/') and not (self.source / script).exists():
                self.fail(block, f'there is no {script}')
            return None
        at = self.folder / '.at'
        done = subprocess.run(['bash', '-euo', 'pipefail', '-c', f'{command}\npwd > "{at}"'], cwd=self.here,
                              env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            self.fail(block, f'{command}\nended with status {done.returncode}\n{done.stdout}')
        self.here = pathlib.Path(at.read_text().strip())
        return done.stdout.splitlines()

    def console(self, block):
        for command, shown in commands_of(block.lines):
            printed = self.run(block, command)
            if shown and printed is not None and not output_agrees(shown, printed):
                self.fail(block, '\n'.join([f'{command}\nprints', *printed, 'and the page shows', *shown]))

    def shell(self, block):
        waiting = ''
        for line in block.lines:
            waiting += line
            if waiting.endswith('\\'):
                waiting = waiting[:-1]
                continue
            if waiting.strip():
                self.run(block, waiting.strip())
            waiting = ''

    def file(self, block):
        (self.here / block.name).write_text(block.text())
        if block.name.endswith('.cpp'):
            program = pathlib.Path(block.name).stem
            if not (self.programs / program).exists():
                self.fail(block, f'the build did not make {self.programs / program}')
            (self.here / program).symlink_to(self.programs / program)

    def carry_out(self, block):
        if block.language == 'toml':
            tomllib.loads(block.text())
        if block.name:
            self.file(block)
        elif block.language == 'console':
            self.console(block)
        elif block.language == 'sh':
            self.shell(block)
        elif block.language == 'cpp':
            self.fail(block, 'a C++ block needs a name, so that the build makes a program of it')
        if block.language == 'python':
            name = block.name or '.block.py'
            (self.here / name).write_text(block.text())
            self.run(block, f'/usr/bin/python3 {name}')


def main():
    if sys.argv[1] == '--extract':
        found = [block for block in blocks_of(pathlib.Path(sys.argv[3])) if block.name == sys.argv[2]]
        if len(found) != 1:
            sys.exit(f'{sys.argv[3]}: {len(found)} blocks with the name {sys.argv[2]}')
        print(found[0].text(), end='')
        return
    page, source, trunnion, programs = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    blocks = blocks_of(page)
    with tempfile.TemporaryDirectory() as folder:
        carried_out = Page(page, source, trunnion, programs, pathlib.Path(folder))
        for block in blocks:
            carried_out.carry_out(block)
    print(f'{len(blocks)} blocks')


if __name__ == '__main__':
    main()
