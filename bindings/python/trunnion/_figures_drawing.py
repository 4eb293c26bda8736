"""What all figures of the papers share: how one is declared, its colours, and how it is written."""
from dataclasses import dataclass
from typing import Callable

GREY, BLUE, RED, GREEN = '#666666', '#0072B2', '#D55E00', '#009E73'  # Okabe and Ito: told apart by the colour-blind
COUNTERPART = {'reproduced': '', 'stand-in': ' (stand-in)', 'text': ' (what the text says)'}


@dataclass(frozen=True)
class PaperFigure:
    """A figure of a paper.

    `kind`: `reproduced` from what the paper gives; `stand-in` where it does not give the part, which is then one of our own;
    `text` for what the paper says without drawing it.
    """
    name: str
    paper: str
    number: str
    title: str
    kind: str
    size: tuple
    draw: Callable

    def drawn(self):
        """The picture and its numbers: {name: (ours, published or None)}."""
        from matplotlib.figure import Figure
        picture = Figure(figsize=self.size, layout='constrained')
        numbers = self.draw(picture)
        picture.suptitle(f'{self.paper}, {self.number}: {self.title}{COUNTERPART[self.kind]}', fontsize=11)
        return picture, numbers


def figure(name, paper, number, title, *, kind='reproduced', size=(8, 4)):
    """Declares a function that draws on a picture and returns its numbers as a PaperFigure."""
    return lambda draw: PaperFigure(name, paper, number, title, kind, size, draw)


def declared(names):
    """The figures among the names of a module, by their names."""
    return {one.name: one for one in names.values() if isinstance(one, PaperFigure)}


def write(one, folder):
    """Writes a figure as PNG and SVG, with the same bytes every time; its numbers."""
    import matplotlib
    style = {'font.size': 10, 'axes.spines.top': False, 'axes.spines.right': False, 'axes.titlesize': 10,
             'legend.frameon': False, 'svg.hashsalt': 'trunnion'}
    with matplotlib.rc_context(style):
        picture, numbers = one.drawn()
        picture.savefig(folder / f'{one.name}.svg', metadata={'Date': None})
        picture.savefig(folder / f'{one.name}.png', dpi=110, metadata={'Software': None})
    return numbers
