"""What all pictures have in common: colours that all can tell apart, a figure that needs no screen, SVG for a page."""

from __future__ import annotations

import io
import re
from html import escape
from typing import Any

import numpy as np

from fleet.analysis.series import Floats, Series
from fleet.errors import UsageError

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")  # Okabe and Ito (2008)
STYLES = ("-", "--", ":", "-.")  # the next seven boats
INK, FAINT, ALARM = "#333333", "#767676", "#B00020"
MOST_LEGEND = 24
MOST_POINTS = 1200  # of a line in a picture: more than a screen has columns


def canvas() -> tuple[Any, Any]:
    """A figure that needs no screen, and the style of ours.

    Raises:
        UsageError: matplotlib is not installed
    """
    try:
        import matplotlib
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        message = 'pictures need matplotlib, which is not installed: pip install "fleet-usv[plots]"'
        raise UsageError(message) from error
    ours: Any = {
        "font.size": 9.0,
        "axes.titlesize": 10.0,
        "axes.titlelocation": "left",
        "axes.edgecolor": FAINT,
        "axes.labelcolor": INK,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": "#e6e6e6",
        "xtick.color": INK,
        "ytick.color": INK,
        "lines.linewidth": 1.6,
        "legend.frameon": False,
        "text.parse_math": False,
        "svg.fonttype": "none",
        "svg.hashsalt": "fleet",
        "path.simplify_threshold": 0.3,
    }

    def figure_of(**how: Any) -> Any:
        figure = Figure(**how)
        FigureCanvasAgg(figure)
        return figure

    return figure_of, lambda: matplotlib.rc_context(ours)


def look(series: Series, name: str) -> dict[str, str]:
    """Colour and line style of a boat, the same in every picture of the run."""
    names = sorted({*series.boats, *series.tracks})
    number = names.index(name)
    return {"color": COLOURS[number % 7], "linestyle": STYLES[number // 7 % 4]}


def svg(figure: Any, said: str = "") -> str:
    """A figure as SVG to stand in a page; `said` is what a reader who cannot see it is told."""
    to = io.StringIO()
    with canvas()[1]():
        figure.savefig(to, format="svg")
    drawn = to.getvalue()
    drawn = re.sub(r"<metadata>.*?</metadata>", "", drawn[drawn.index("<svg") :], flags=re.DOTALL)
    drawn = re.sub(r' xmlns:xlink="[^"]*"', "", drawn.replace("xlink:href", "href"))
    drawn = re.sub(r"\n\s*", "\n", drawn)
    if said:
        name = escape(said, quote=True)
        drawn = drawn.replace("<svg ", f'<svg role="img" aria-label="{name}" ', 1)
    return drawn


def unique_ids(drawn: str, prefix: str) -> str:
    """SVG whose names are not those of another picture in the same page."""
    for name in set(re.findall(r'\bid="([^"]+)"', drawn)):
        new = f"{prefix}-{name}"
        drawn = drawn.replace(f'id="{name}"', f'id="{new}"')
        drawn = drawn.replace(f"url(#{name})", f"url(#{new})").replace(f'href="#{name}"', f'href="#{new}"')
    return drawn


def thinned(t: Floats, values: Floats, most: int = MOST_POINTS) -> tuple[Floats, Floats]:
    """A line with at most so many points that keeps every peak: least and greatest of each stretch, in their order."""
    if len(t) <= most:
        return t, values
    size = -(-len(t) // (most // 2))
    padded = np.append(values, np.full(-len(t) % size, np.nan)).reshape(-1, size)
    first = np.arange(len(padded)) * size
    unknown = np.isnan(padded)
    least = first + np.where(unknown, np.inf, padded).argmin(axis=1)
    most_of = first + np.where(unknown, -np.inf, padded).argmax(axis=1)
    chosen = np.unique(np.concatenate(([0], least, most_of, [len(t) - 1])))
    return t[chosen], values[chosen]


def words_on(axis: Any, place: tuple[float, float], words: str, **how: Any) -> None:
    """Words at a place of the data, readable on lines."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.5, foreground="white")]
    chosen = {"xytext": (4, 5), "fontsize": 7.5, "color": INK, "zorder": 8, **how}
    axis.annotate(words, place, textcoords="offset points", path_effects=halo, **chosen)


def legend(axis: Any, **how: Any) -> None:
    """The legend above the right end of a panel, where no line runs."""
    handles = how.get("handles") or axis.get_legend_handles_labels()[0]
    if 0 < len(handles) <= MOST_LEGEND:
        axis.legend(**how, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=8, fontsize=7.5, borderaxespad=0.1,
                    columnspacing=1.2, handlelength=1.6)  # fmt: skip


def runs_of(chosen: Any) -> list[tuple[int, int]]:
    """Stretches of a row of booleans that are true: first, and one past the last."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], np.asarray(chosen, dtype=np.int8), [0]))))
    return [(int(begin), int(end)) for begin, end in zip(edges[::2], edges[1::2], strict=True)]
