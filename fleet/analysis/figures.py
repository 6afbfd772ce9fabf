"""The pictures of a run, with units, in colours all can tell apart: the map, and time series under it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from fleet.analysis.canvas import INK, canvas
from fleet.analysis.chart import Chart, chart_of
from fleet.analysis.figures_map import draw_map, shape
from fleet.analysis.figures_time import draw_panels, panels
from fleet.analysis.metrics import mission_tree
from fleet.analysis.separation import approaches
from fleet.analysis.series import Series, load

WIDTH_IN = 10.0
STRIP_IN, SQUARE_IN = 3.6, 6.4  # heights of the map
PANEL_IN = 1.55  # height of a panel whose share is 1


def draw(folder: Path | str, out: Path | str, series: Series | None = None) -> Path:
    """Draw the picture of the run in a folder into an SVG, PNG or PDF file, by the ending of its name.

    Args:
        folder: a run folder
        out: the picture
        series: the run, if it was loaded already

    Raises:
        UsageError: matplotlib is not installed
    """
    return drawn(picture, folder, out, series, 130)


def drawn(
    figure: Callable[[Series, Chart, str], Any], folder: Path | str, out: Path | str, series: Series | None, dpi: int
) -> Path:
    """Draw one kind of figure of the run in a folder into a file."""
    series = load(folder) if series is None else series
    tree = mission_tree(Path(folder))
    target = Path(out)
    target.parent.mkdir(parents=True, exist_ok=True)
    figure(series, chart_of(tree), title_of(series, tree)).savefig(target, dpi=dpi)
    return target


def title_of(series: Series, tree: dict[str, Any]) -> str:
    """What a run is called: the title of its mission, or the name of its folder."""
    return str(tree.get("title") or series.header.get("mission") or series.folder.name)


def picture(series: Series, chart: Chart, title: str) -> Any:
    """Map and time series as one matplotlib figure."""
    figure_of, style = canvas()
    with style():
        long, flip = shape(series)
        rows = panels(series)
        heights = [STRIP_IN if long else SQUARE_IN, *(PANEL_IN * share for _, share in rows)]
        figure = figure_of(figsize=(WIDTH_IN, sum(heights) + 0.5), layout="constrained")
        figure.suptitle(title, fontsize=13, fontweight="bold", color=INK)
        axes = figure.subplots(len(heights), 1, height_ratios=heights)
        draw_map(axes[0], series, chart, flip)
        axes[0].set_title(_map_title(series))
        draw_panels(axes[1:], series, chart.radius_m)
    return figure


def _map_title(series: Series) -> str:
    pairs = approaches(series.tracks)
    return "Tracks" + (f"; closest approach {pairs[0].distance_m:.2f} m" if pairs else "")


def map_figure(series: Series, chart: Chart) -> Any:
    """The map alone."""
    figure_of, style = canvas()
    with style():
        long, flip = shape(series)
        figure = figure_of(figsize=(WIDTH_IN, STRIP_IN if long else SQUARE_IN), layout="constrained")
        draw_map(figure.subplots(), series, chart, flip)
    return figure


def time_figure(series: Series, chart: Chart) -> Any:
    """The time series alone."""
    figure_of, style = canvas()
    with style():
        heights = [PANEL_IN * share for _, share in panels(series)]
        figure = figure_of(figsize=(WIDTH_IN, sum(heights) + 0.4), layout="constrained")
        axes = figure.subplots(len(heights), 1, height_ratios=heights, squeeze=False)
        draw_panels(list(axes[:, 0]), series, chart.radius_m)
    return figure
