"""The notebooks of docs/notebooks: each runs to its last cell, with and without $HOLDFAST_DATA, and is kept without outputs."""
import json
import os
import pathlib

import pytest

NOTEBOOKS = sorted((pathlib.Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


def test_there_are_three_and_they_are_kept_without_outputs():
    assert [path.stem for path in NOTEBOOKS] == ["false_loops", "plaza2", "swarm"]
    for path in NOTEBOOKS:
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            assert not cell.get("outputs"), f"{path.name}: clear the outputs before you commit it"
            draws = cell["cell_type"] == "code" and "plt.show()" in "".join(cell["source"])
            assert not draws or cell["metadata"]["mystnb"]["image"]["alt"], f"{path.name}: a figure without words for who cannot see it"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
@pytest.mark.parametrize("data", ["with data", "without"])
def test_it_runs(path, data, monkeypatch):
    pytest.importorskip("ipykernel", reason="ipykernel is not installed (pip install nbclient ipykernel): the notebooks were not run")
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: the notebooks were not run")
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    if data == "with data" and "HOLDFAST_DATA" not in os.environ:
        pytest.skip("HOLDFAST_DATA names no folder of data")
    if data == "without":
        monkeypatch.delenv("HOLDFAST_DATA", raising=False)
    content = nbformat.read(path, 4)
    nbclient.NotebookClient(content, timeout=120, kernel_name="python3").execute()
    shown = [output for cell in content.cells for output in cell.get("outputs", [])]
    assert any("image/svg+xml" in output.get("data", {}) for output in shown)
    said = "".join(output.get("text", "") for output in shown)
    assert ("a small simulated" in said) == (data == "without" and path.stem != "swarm")
