"""The documentation site in a browser, after scripts/docs: nothing fetched, no word on the console, nothing that axe-core calls serious."""
import pathlib

import pytest
from browser import chromium, faults, opened, served

SITE = pathlib.Path(__file__).resolve().parents[2] / "build" / "site"
PAGES = sorted(str(path.relative_to(SITE)) for path in SITE.rglob("*.html") if path.parts[len(SITE.parts)] != "source")
PAGES += ["source/graph/loss.hpp.html"]  # one of the pages that show a file


@pytest.mark.parametrize("width,scheme", [("phone", "dark"), ("desktop", "light")])
def test_every_page_of_the_site(width, scheme):
    assert (SITE / "index.html").is_file(), "build/site is not there: run scripts/docs first"
    assert len(PAGES) > 25
    found = []
    with served(SITE) as address, chromium() as browser:
        for name in PAGES:
            with opened(browser, f"{address}/{name}", width, scheme) as (page, complaints):
                found += [f"{name}: {fault}" for fault in faults(page) + complaints]
    assert found == []


def test_a_page_with_faults_is_found_out(tmp_path):
    (tmp_path / "bad.html").write_text("<!doctype html><html lang=en><title>x</title><img src=x.png><p style='width:3000px'>wide</p>"
                                       "<link rel=icon href='data:,'><script>nothing.here()</script>", encoding="utf-8")
    with served(tmp_path) as address, chromium() as browser, opened(browser, f"{address}/bad.html") as (page, complaints):
        assert any("nothing is not defined" in complaint for complaint in complaints)
        found = faults(page)
        assert any(fault.startswith("image-alt") for fault in found) and any("pixels wide" in fault for fault in found)
