"""Every diagnostic code of the sources stands in docs/diagnostics.md, and the other way round.   codes_test.py SOURCE_DIR"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
pattern = re.compile(r'"((?:BASE|GEOM|MACH|FILE|NC|PATH|SMTH|FEED|CTRL|VER|PIPE|REP|DEFO|SURF|INTP|PY|RT)\d{4})"')
used = {code for folder in ('src', 'apps', 'bindings') for f in (root / folder).rglob('*.?pp') for code in pattern.findall(f.read_text())}
told = set(re.findall(r'^\| ([A-Z]+\d{4}) \|', (root / 'docs/diagnostics.md').read_text(), re.M))
if used - told or told - used:
    sys.exit(f'only in the sources: {sorted(used - told)}\nonly in docs/diagnostics.md: {sorted(told - used)}')
print(f'{len(used)} codes')
