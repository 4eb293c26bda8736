"""Every block of docs/python.md runs, in order."""
import re

from conftest import ROOT


def test_the_guide(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    blocks = re.findall(r'^```python\n(.*?)^```', (ROOT / 'docs/python.md').read_text(), re.M | re.S)
    assert len(blocks) == 8
    names = {}
    for block in blocks:
        exec(compile(block, 'docs/python.md', 'exec'), names)
    assert 'cycle time' in capsys.readouterr().out and len(names['text']) > 1000 and names['gain'] < 1
