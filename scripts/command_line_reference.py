#!/usr/bin/python3
"""Writes docs/reference/command-line.md from what the program says of itself: --help of every command.

    scripts/command_line_reference.py TRUNNION [--check]     --check: status 1 where the page is not what would be written

Run it after a change of options, and commit what it writes."""
import pathlib
import re
import subprocess
import sys

PAGE = pathlib.Path(__file__).resolve().parent.parent / 'docs/reference/command-line.md'
HEAD = """# Command line
This page is written by `scripts/command_line_reference.py` from `--help` of every command.

Options stand before or behind operands. Machines and controllers are given by the name of a shipped one or by file. Results go to standard
output or to the file of `-o`, messages and progress to standard error.
"""


def help_of(trunnion, words):
    done = subprocess.run([trunnion, *words, '--help'], capture_output=True, text=True, check=True)
    return done.stdout.rstrip('\n').split('\n')


def commands_of(lines):
    """Names in the section `Subcommands:`."""
    out, inside = [], False
    for line in lines:
        if line == 'Subcommands:':
            inside = True
        elif inside and not line.startswith('  '):
            inside = False
        elif inside and re.match(r'  \w', line):
            out.append(line.split()[0])
    return out


def code(text):
    return f'`{text}`'


def table(title, rows):
    """Names and meanings: help prints them in two columns, or one below the other."""
    pairs = []
    for line in rows:
        name, _, meaning = line.strip().partition('  ')
        if re.match(r' {2,4}\S', line):
            pairs.append((name, meaning.strip()))
        else:
            pairs[-1] = (pairs[-1][0], line.strip())
    body = [f'| {code(name)} | ' + meaning.replace('|', '\\|') + ' |' for name, meaning in pairs]
    return ['', f'| {title} | |', '|---|---|', *body, '']


def as_markdown(lines):
    """What --help prints: sentences as they are, lists under their titles as tables."""
    out, title, rows = [], '', []
    for line in [*lines, '']:
        heading = re.fullmatch(r'\s*(?:\[Option Group: (.*)\]|(\w+):)\s*', line)
        if line.startswith('  ') and not heading:
            rows.append(line)
            continue
        if title and rows:
            out += table(title, rows)
        elif rows:  # what a group says of its options
            out.append('; '.join(row.strip(' []') for row in rows))
        rows = []
        if heading:
            title = heading[2]
        elif line.startswith('Usage: '):
            out += ['', code(line.removeprefix('Usage: ')), '']
        else:
            title = '' if line else title
            out.append(line.strip())
    return re.sub(r'\n{3,}', '\n\n', '\n'.join(out)).strip()


def section(trunnion, words, own_examples):
    lines = help_of(trunnion, words)
    names = commands_of(lines)
    example = []
    if 'Example:' in lines:
        at = lines.index('Example:')
        example, lines = [line.strip() for line in lines[at + 1:]], lines[:at]
    title = ' '.join(['trunnion', *words])
    out = f'\n## {title}\n{as_markdown(lines)}\n'
    if example and example not in own_examples:
        own_examples.append(example)
        body = '\n'.join(example)
        out += f'\n```sh\n{body}\n```\n'
    return out + ''.join(section(trunnion, [*words, name], own_examples) for name in names)


def main():
    written = HEAD + section(sys.argv[1], [], [])
    if '--check' not in sys.argv:
        PAGE.write_text(written)
    elif not PAGE.exists() or PAGE.read_text() != written:
        sys.exit(f'{PAGE} is not what --help says: scripts/command_line_reference.py {sys.argv[1]}')


main()
