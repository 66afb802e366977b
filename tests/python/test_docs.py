"""The code of docs/python.md, block by block."""
import pathlib
import re

import pytest

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "python.md"
FILE = """VERTEX_SE2 0 A0 0 0 0
VERTEX_SE2 1 A1 1 0 0
VERTEX_XY L0 1 2
EDGE_SE2 0 A0 A1 1 0 0 0.0025 0 0 0.0025 0 0.0001
EDGE_RANGE 0 A0 L0 2.24 0.01
EDGE_RANGE 1 A1 L0 2.0 0.01
"""


def test_every_block_runs(tmp_path, monkeypatch):
    pytest.importorskip("plotly")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.pyfg").write_text(FILE, encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 9
    names = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    assert names["summary"].usable
    assert (tmp_path / "two.html").exists()
    assert names["covariance"].shape == (3, 3)
    assert len(names["smoother"]) == 50
