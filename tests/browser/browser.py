"""Pages as a person with a browser finds them: in headless Chromium, by Playwright, and judged by axe-core."""
import contextlib
import functools
import http.server
import shutil
import threading

import pytest

CHROMIUM = next((path for path in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if path), None)
WIDTHS = {"phone": 390, "desktop": 1280}


class Silent(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@contextlib.contextmanager
def served(folder):
    """The address at which the folder is served."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Silent, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@contextlib.contextmanager
def chromium():
    if CHROMIUM is None:
        pytest.skip("no Chromium (Debian: apt install chromium): no page was looked at")
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright (pip install playwright): no page was looked at")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextlib.contextmanager
def opened(browser, address, width="desktop", scheme="light"):
    """(page, what it complained of: messages of its console, errors, and whatever it fetched from elsewhere)"""
    page = browser.new_page(viewport={"width": WIDTHS[width], "height": 900}, color_scheme=scheme)
    complaints, home = [], address.partition("://")[2].partition("/")[0]
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: request.url.startswith(("data:", "blob:", "file:", f"http://{home}")) or
            complaints.append(f"fetched {request.url}"))
    page.goto(address, wait_until="networkidle")
    yield page, complaints
    page.close()


def faults(page):
    """What axe-core finds of serious or critical impact, and a page that is wider than its window."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe-core (pip install axe-playwright-python)")
    found = [f"{rule['id']}: {node['html'][:200]}" for rule in axe.Axe().run(page).response["violations"]
             if rule["impact"] in ("serious", "critical") for node in rule["nodes"]]
    wide, window = page.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
    return found + ([f"{wide} pixels wide in a window of {window}"] if wide > window else [])
