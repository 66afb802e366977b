"""How Sphinx builds the documentation site. scripts/docs runs it on what sources.py has put together."""
import pathlib
import re

root = pathlib.Path(__file__).resolve().parents[2]
project = "holdfast"
author = "the holdfast developers"
release = re.search(r"project\(holdfast VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
extensions = ["myst_parser"]
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
