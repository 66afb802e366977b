"""The page of results in a browser: every figure is drawn, the numbers are those of the lines, axe-core finds nothing serious."""
import csv
import io
import json
import pathlib
import sys

import pytest
from browser import chromium, faults, opened

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from test_report import figures, report, whole_page  # noqa: E402

CELLS = "table => [...table.rows].map(row => [...row.cells].map(cell => cell.textContent))"


def unfold(page):
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")  # opens and draws everything, as before it is printed
    page.wait_for_timeout(200)


@pytest.mark.parametrize("width", ["phone", "desktop"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_is_drawn_without_a_word_and_without_faults(tmp_path, width, scheme):
    pytest.importorskip("plotly")
    path = whole_page(tmp_path)
    with chromium() as browser, opened(browser, path.as_uri(), width, scheme) as (page, complaints):
        unfold(page)
        traces = page.evaluate("[...document.querySelectorAll('.plot')].map(plot => plot.data.map(trace => [trace.x, trace.y]))")
        assert faults(page) + complaints == []
    said = [[[trace["x"], trace["y"]] for trace in figure] for figure in figures(path.read_text(encoding="utf-8"))]
    assert traces == said and len(said) >= 6


def test_it_fits_on_paper(tmp_path):
    pytest.importorskip("plotly")
    path = whole_page(tmp_path)
    wide = {f"a_field_with_quite_a_long_name_{i}": 0.1234567 * i for i in range(12)}
    with open(tmp_path / "online.jsonl", "a", encoding="utf-8") as file:
        file.write(json.dumps({"window": "with many fields", "suite": "online", "commit": "abc", **wide}) + "\n")
    assert report.main([str(tmp_path)]) is None
    with chromium() as browser, opened(browser, path.as_uri()) as (page, _):
        page.set_viewport_size({"width": 1047, "height": 718})  # A4, landscape, less a centimetre on each side
        page.emulate_media(media="print", color_scheme="dark")
        unfold(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= 1047
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"  # whatever the screen is like


def test_the_numbers_in_its_table_are_those_of_the_lines(tmp_path):
    pytest.importorskip("plotly")
    path = whole_page(tmp_path)
    lines = [json.loads(line) for line in (tmp_path / "data.jsonl").read_text(encoding="utf-8").splitlines()]
    with chromium() as browser, opened(browser, path.as_uri()) as (page, _):
        table = page.locator("div[aria-label='Suite data: every run'] table")
        titles, *rows = table.evaluate(CELLS)
        with page.expect_download() as download:
            page.locator("button[aria-label='CSV: Suite data: every run']").click()
        saved = pathlib.Path(download.value.path()).read_text(encoding="utf-8")
    assert len(rows) == len(lines)
    found = {(row[0], row[3]): dict(zip(titles, row)) for row in rows}
    for line in lines:
        row = found[report.stem(line["file"]), line["backend"]]
        assert row["cost"] == report.number(line["cost"], ".9g") and row["s"] == report.number(line["seconds"])
        assert row["iterations"] == str(line["iterations"]) and row["ended"] == line["termination"]
    assert list(csv.reader(io.StringIO(saved))) == [titles, *rows]


def test_it_opens_soon(tmp_path):
    """Only the figures in view are drawn: how many those are does not depend on how many there are."""
    pytest.importorskip("plotly")
    path = whole_page(tmp_path)
    with chromium() as browser, opened(browser, path.as_uri()) as (page, _):
        page.wait_for_selector("[data-drawn] .main-svg")
        drawn, all_of_them = (page.locator(what).count() for what in ("[data-drawn]", ".plot"))
    assert 0 < drawn < all_of_them
