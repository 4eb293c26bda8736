"""Numbers of the figures of the papers: within bounds of our own, which hold the published ones wherever they can be met."""
import re

import pytest

pytest.importorskip('matplotlib')

from trunnion import figures  # noqa: E402

from conftest import ROOT  # noqa: E402

PAGE = (ROOT / 'docs/figures.md').read_text()
PICTURES = ROOT / 'docs/pictures/papers'
BOUNDS = {
    'beudaert-1': {'distance of the corner, µm': (19.999, 20.001), 'L1 by Eq. 3, µm': (56.568, 56.569),
                   'L2/L1, chosen in the text': (1.3999, 1.4001)},
    'beudaert-2': {'tip from its corner, mm': (2.999, 3.001), 'top from its corner, mm': (2.8, 3.001),
                   'first turn of 1/20 of u, linear link, deg': (0.4, 0.7),
                   'first turn of 1/20 of u, optimised link, deg': (0.1, 0.25)},
    'beudaert-3': {'jump of dn/ds at the entry, linear link, of dn/ds': (1, 5),
                   'jump of dn/ds at the entry, optimised link, of dn/ds': (0, 1e-6)},
    'beudaert-5': {'f ′ at the entry': (0.8, 0.95), 'least f ′': (0.1, 0.95), 'u_top at the exit': (1 - 1e-12, 1 + 1e-12)},
    'beudaert-6': {'feed limit at u_top1 = u_bottom1, mm/min': (0, 150), 'feed limit at the optimum, mm/min': (2000, 3000),
                   'feed limit 1e-6 beside it, mm/min': (100, 1000), 'minima of the criterion': (1, 1)},
    'beudaert-8': {'least limit of Eq. 10, linear link, mm/min': (0, 150), 'least planned feed, linear link, mm/min': (0, 50),
                   'least limit of Eq. 10, optimised link, mm/min': (1500, 3000),
                   'least planned feed, optimised link, mm/min': (1000, 3000)},
    'beudaert-9': {'time with the spline / linear, corner': (0.4, 0.55),
                   'time with the spline / linear, whole program': (0.6, 0.85)},
    'beudaert-10': {'tip off the program, mm': (0.01, 0.02), 'cycle time, s': (5, 10)},
    'beudaert-11': {'least limit of Eq. 10, linear link, mm/min': (0, 30), 'least planned feed, linear link, mm/min': (0, 10),
                    'least limit of Eq. 10, optimised link, mm/min': (50, 100),
                    'least planned feed, optimised link, mm/min': (35, 100),
                    'f ′ with 0.02 mm above as well': (1 - 1e-9, 1 + 1e-9)},
    'affouard-1': {'distance off, 8 poses, mm': (0.06, 0.09), 'distance off, 30 poses, mm': (1e-4, 5e-4),
                   'distance off where 1 µm is asked for, mm': (1e-5, 1e-3)},
    'affouard-2': {'planned contacts off Eq. 1, mm': (0, 1e-9), 'largest distance S to S₁, mm': (2 - 1e-9, 2 + 1e-9)},
    'affouard-deformation': {'peak before, µm': (15, 15.5), 'peak after, µm': (0.1, 0.4)},
    'lin-koren-3': {'interval / cutter diameter': (1 - 1e-9, 1 + 1e-9)},
    'lin-koren-4': {'largest difference from Eq. 2, of P': (0, 1e-12), 'ridge of simulated passes on a cylinder / h': (0.9, 1)},
    'lin-koren-5': {'passes': (20, 30), 'highest ridge / allowed': (0.9, 1), 'deepest cut into the part, µm': (0, 1)},
    'lin-koren-6': {'segments within 1 µm': (55, 55), 'chord error, µm': (0.99, 1),
                    'largest orientation error, deg': (0.0165, 0.0175),
                    'linear in u instead, deg': (0.006, 0.0065), 'position error of 0.017°, µm': (45.595, 45.597),
                    'length of the curve, mm': (29.127, 29.129)},
    'lin-koren-eq5': {'ripple, order 1, 0.05 mm a period, %': (0.49, 0.51), 'ripple, order 1, 0.01 mm a period, %': (0.095, 0.101),
                      'ripple, order 2, 0.05 mm a period, %': (0.001, 0.005)},
    'lavernhe-table-2': {'k from which there is one': (-0.5005, -0.4995), 'k from which there are two': (0.8655, 0.8665)},
    'lavernhe-4': {'largest error in one part, mm': (20, 35), 'error of 8 parts / of 16': (3.9, 4.1)},
    'lavernhe-7': {'highest feed, 10 blocks / 1 block': (2, 5), 'highest feed, 10 blocks, mm/min': (9000, 10000 + 1e-6)},
    'lavernhe-8': {'chords on the blend': (13, 15)},
    'lavernhe-9': {'movement of X, mm': (0, 1e-9), 'movement of C, deg': (0, 1e-9), 'movement of A, deg': (90 - 1e-9, 90 + 1e-9)},
    'lavernhe-10': {'limit of A / programmed, on the blend': (0.15, 0.25), 'A is the lowest there': (1, 1),
                    'way of a cycle at 20 m/min, mm': (1 - 1e-9, 1 + 1e-9)},
    'lavernhe-11': {'highest velocity of A, rpm': (24, 25 + 1e-6), 'highest velocity of Y, m/min': (4.9, 5 + 1e-6)},
    'lavernhe-12': {f'{name}: {what}': bounds for name, ratio in (('concave', 1.24), ('convex', 1.35)) for what, bounds in {
        'feed on the straights, mm/min': (4999, 5000 + 1e-6), 'feed at the ends of the blend, mm/min': (0, 100),
        'highest on the blend, mm/min': (940, 1060), 'way of the tip / of the contact': (ratio - 0.01, ratio + 0.01)}.items()},
}


def test_every_figure_has_bounds():
    assert set(BOUNDS) == set(figures.FIGURES)


@pytest.mark.parametrize('name', BOUNDS)
def test_numbers(name):
    numbers = figures.numbers_of(name)
    assert set(numbers) == set(BOUNDS[name])
    for what, (ours, published) in numbers.items():
        low, high = BOUNDS[name][what]
        assert low <= ours <= high, f'{what}: {ours}, published {published}'
        told = re.search(rf'^\| `{name}` \| {re.escape(what)} \| (\S+) \| (\S*) ?\|$', PAGE, re.M)
        assert float(told[1]) == pytest.approx(ours, rel=0.01, abs=1e-4), what
        assert told[2] == ('' if published is None else f'{published:.4g}'), what


def test_files_are_the_same_every_time(tmp_path):
    first, second = tmp_path / 'first', tmp_path / 'second'
    for folder in (first, second):
        assert figures.main(['lin-koren-4', '-o', str(folder)]) == 0
    assert sorted(file.name for file in first.iterdir()) == ['lin-koren-4.png', 'lin-koren-4.svg']
    for file in first.iterdir():
        assert file.read_bytes() == (second / file.name).read_bytes()


def test_list_and_refusals(capsys):
    assert figures.main(['--list']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(figures.FIGURES) and lines[0].startswith('beudaert-1 ')
    for wrong in (['lin-koren-99', '-o', 'x'], []):
        with pytest.raises(SystemExit) as caught:
            figures.main(wrong)
        assert caught.value.code == 2
    assert 'lin-koren-99' in capsys.readouterr().err


def test_the_page_has_every_figure():
    assert set(re.findall(r'^\| `([\w-]+)` \| .* \| (?:reproduced|stand-in|text) \|', PAGE, re.M)) == set(figures.FIGURES)
    for one in figures.FIGURES.values():
        assert f'| `{one.name}` | {one.number} | {one.kind} |' in PAGE
        assert f'](pictures/papers/{one.name}.svg)' in PAGE
        assert (PICTURES / f'{one.name}.svg').stat().st_size < 200_000
    assert {file.stem for file in PICTURES.iterdir()} == set(figures.FIGURES)
