"""How Sphinx builds the documentation site. scripts/docs runs it on what sources.py has put together."""
import importlib.util
import pathlib
import re

root = pathlib.Path(__file__).resolve().parents[2]
project = "holdfast"
author = "the holdfast developers"
release = re.search(r"project\(holdfast VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
extensions = ["myst_nb"]
# The notebooks are run, and a cell that fails ends the build. scripts/docs says so where there is no module to run them with.
nb_execution_mode = "force" if importlib.util.find_spec("holdfast") else "off"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 6
nitpicky = True
# The code on the pages leaves lines out by "…", which is no C++ or Python; it is still coloured.
suppress_warnings = ["misc.highlighting_failure"]
html_theme = "furo"
html_title = f"holdfast {release}"
html_static_path = ["theme.css"]
html_css_files = ["theme.css"]
html_show_sourcelink = False
html_show_copyright = False

# What keyboards and screen readers need and the theme leaves out: parts that scroll take the focus, and headings say their level. No
# browser asks for an icon that is not there.
MENDED = [('<pre>', '<pre tabindex="0">'), ('class="table-wrapper', 'tabindex="0" class="table-wrapper'),
          ('class="caption" role="heading"', 'class="caption" role="heading" aria-level="2"'),
          ('</head>', '<link rel="icon" href="data:,"></head>')]


def mend(app, failure):
    for page in [] if failure else pathlib.Path(app.outdir).rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        for found, better in MENDED:
            text = text.replace(found, better)
        page.write_text(text, encoding="utf-8")


def setup(app):
    app.connect("build-finished", mend)
