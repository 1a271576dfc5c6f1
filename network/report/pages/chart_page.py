"""One page for every result: title, sentences, tables, charts. One file, nothing fetched, no name taken for markup."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING

from network.platform.quantities.text_table import write_sign
from network.report.pages.chart import Chart, share_points, tell_chart

if TYPE_CHECKING:
    from markupsafe import Markup

TEMPLATE = "chart_page.html.j2"
_NUMBER = re.compile(r"\s*([-−+±]?\.?\d|[-–—]?\s*$)")
"""How a cell begins that is a number, or none."""
PAGE = "report.html"
"""The file that `--page` writes."""


@dataclass(frozen=True)
class Table:
    """Cells as text. A column of numbers stands to the right, signs are true minus."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""

    @property
    def columns(self) -> list[str]:
        """The style of each column: number, or nothing."""
        cells = zip(*self.rows, strict=True) if self.rows else ([""] for _ in self.header)
        return ["number" if all(map(_NUMBER.match, column)) else "" for column in cells]

    @property
    def lines(self) -> list[list[tuple[str, str]]]:
        """Rows of cells, each with the style of its column."""
        return [[*zip(map(write_sign, row), self.columns, strict=True)] for row in self.rows]


@dataclass(frozen=True)
class Page:
    """basis: sentences below the title; notes: those below the tables; picture: of the page's own, as markup."""

    title: str
    basis: Sequence[str]
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()
    charts: Sequence[Chart] = ()
    caption: str = ""
    footer: str = ""
    picture: Markup | str = field(default="")


def fill_page(page: Page) -> str:
    """The page as HTML."""
    from jinja2 import Environment, PackageLoader
    from markupsafe import Markup

    rooms = Environment(loader=PackageLoader("network.report"), autoescape=True, trim_blocks=True, lstrip_blocks=True)
    style = Markup(read_asset("page.css")) + chart_style()
    return rooms.get_template(TEMPLATE).render(
        title=page.title, basis=page.basis, tables=page.tables, notes=page.notes, footer=page.footer,
        picture=page.picture, charts=show_charts(page.charts, page.caption), style=style, policy=write_policy(),
        script=write_script() if page.charts else "",
    )  # fmt: skip


def show_charts(charts: Sequence[Chart], caption: str = "") -> Markup:
    """The charts of several runs, drawn, each with its data for the script; nothing where there are none."""
    from markupsafe import Markup

    if not charts:
        return Markup("")
    told = Markup('<p class="quiet">{}</p>\n').format(caption) if caption else Markup("")
    points = share_points(charts)
    return told + Markup('<div class="charts">\n{}</div>\n').format(
        Markup("").join(_show_run(chart, *points) for chart in charts)
    )


def _show_run(chart: Chart, most: int, drawn: int) -> Markup:
    from markupsafe import Markup

    from network.report.pages.chart_svg import draw_chart

    keys = Markup("").join(_show_key(key, *look) for key, look in chart.keys.items())
    data = Markup('<script type="application/json" class="chart-data">{}</script>').format(
        Markup(tell_chart(chart, most))
    )
    head = Markup('<figure class="run" data-name="{}">\n<figcaption>{}</figcaption>\n').format(chart.name, chart.name)
    return head + Markup('<ul class="keys">{}</ul>\n{}\n{}\n</figure>\n').format(keys, draw_chart(chart, drawn), data)


def _show_key(key: str, colour: str, dash: str) -> Markup:
    """A channel in the legend, which the script makes a switch."""
    from markupsafe import Markup

    swatch = Markup(
        '<svg viewBox="0 0 26 8" aria-hidden="true"><path d="M0 4H26" stroke="{}" stroke-width="2" '
        'stroke-dasharray="{}"/></svg>'
    ).format(colour, dash or "none")
    shown = swatch if colour else Markup("")
    return Markup('<li class="key" data-key="{}">{}<span>{}</span></li>').format(key, shown, key)


@lru_cache
def read_asset(name: str) -> str:
    """A style or script that travels with the package."""
    return (files("network.report") / "templates" / name).read_text(encoding="utf-8")


def chart_style() -> Markup:
    """The style of charts, for a style sheet inside a page."""
    from markupsafe import Markup

    return Markup(read_asset("chart.css"))


def write_script() -> Markup:
    """The script of the charts, inside the page."""
    from markupsafe import Markup

    return Markup("<script>{}</script>\n").format(Markup(read_asset("chart.js")))


def write_policy() -> Markup:
    """What the page may do: show its own pictures and run its one script, known by its hash. Nothing is fetched."""
    from markupsafe import Markup

    digest = base64.b64encode(hashlib.sha256(read_asset("chart.js").encode("utf-8")).digest()).decode("ascii")
    rules = f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{digest}'"
    return Markup('<meta http-equiv="Content-Security-Policy" content="{}">').format(Markup(rules))
