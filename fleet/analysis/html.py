"""Pages in one file: style, tables, numbers with their units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; margin: 2rem auto; max-width: 70rem;
 padding: 0 1rem; }
h1 { margin-bottom: 0; line-height: 1.25; } h2 { margin-top: 2.2rem; font-size: 1.15rem; }
.run { color: #595959; margin-top: .2rem; } table { border-collapse: collapse; }
th, td { text-align: left; padding: .25rem .9rem .25rem 0; vertical-align: top; }
thead th { border-bottom: 1px solid #999; vertical-align: bottom; }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
tbody tr:nth-child(even) { background: #f5f5f5; } .ok { color: #00664b; } .bad { color: #b00020; font-weight: 600; }
.verdict { display: inline-block; padding: .15rem .7rem; border-radius: .3rem; color: #fff; background: #b00020;
 font-size: 1.2rem; vertical-align: middle; }
.verdict.ok { background: #00664b; color: #fff; } .verdict.none { background: #595959; }
.means { color: #595959; } .note { background: #fff4d6; padding: .5rem .8rem; }
.wide { overflow-x: auto; } figure { margin: 1rem 0; overflow-x: auto; } figcaption { color: #595959; }
svg { width: 100%; height: auto; min-width: 40rem; }
dl.glance { display: grid; grid-template-columns: repeat(auto-fill, minmax(13rem, 1fr)); gap: .6rem; margin: 1rem 0; }
dl.glance > div { border: 1px solid #ddd; border-left: .3rem solid #999; padding: .4rem .7rem; }
dl.glance > div.ok { border-left-color: #00664b; color: inherit; }
dl.glance > div.bad { border-left-color: #b00020; color: inherit; font-weight: inherit; }
dl.glance dt { color: #595959; font-size: .85rem; } dl.glance dd { margin: 0; }
dl.glance dd.big { font-size: 1.3rem; font-variant-numeric: tabular-nums; }
.key { display: inline-block; width: .8em; height: .8em; border-radius: .15em; margin-right: .4em; }
pre { background: #f5f5f5; padding: .8rem; overflow-x: auto; }
@media print { body { margin: 0; max-width: none; font-size: 10pt; } svg { min-width: 0; } .wide, figure, pre {
 overflow: visible; } pre { white-space: pre-wrap; } h2 { break-after: avoid; } figure, tr, dl.glance > div {
 break-inside: avoid; } * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
"""


def html_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are HTML already; numbers stand to the right, and a wide table scrolls alone."""
    head = "".join(f'<th scope="col">{one}</th>' for one in heads)
    body = "".join("<tr>" + "".join(_cell(one) for one in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _cell(content: str) -> str:
    return f'<td class="n">{content}</td>' if re.fullmatch(r"[-+]?[\d.]+( \S+)?", content) else f"<td>{content}</td>"


def shown(value: float | None, unit: str = "") -> str:
    """A figure with its unit, to two places; `none` where it does not exist."""
    if value is None or not np.isfinite(value):
        return "none"
    number = f"{value:.2f}" if isinstance(value, float) and value != int(value) else f"{value:.0f}"
    return f"{number.replace('-0.00', '0.00')} {unit}".strip()


def verdict(words: str, good: bool | None) -> str:
    """`passed`, `failed`, or neither, on a ground of colour."""
    kind = " none" if good is None else " ok" if good else ""
    return f'<span class="verdict{kind}">{words}</span>'


def cards(content: Iterable[tuple[str, str, str, bool | None]]) -> str:
    """Main figures at a glance: (name, value, when and who, good or bad or neither), HTML already."""
    parts = []
    for name, value, more, good in content:
        kind = "" if good is None else ' class="ok"' if good else ' class="bad"'
        said = f"<dd>{more}</dd>" if more else ""
        parts.append(f'<div{kind}><dt>{name}</dt><dd class="big">{value}</dd>{said}</div>')
    return f'<dl class="glance">{"".join(parts)}</dl>' if parts else ""


def figure(drawn: str, caption: str) -> str:
    """A picture with its words; both HTML already."""
    return f"<figure>{drawn}<figcaption>{caption}</figcaption></figure>" if drawn else ""
