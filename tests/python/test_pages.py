"""The Python code of the pages for newcomers, and the drawings of the losses and the factors."""
import importlib.util
import os
import pathlib
import re

import numpy as np
import pytest

import holdfast as hf

DOCS = pathlib.Path(__file__).parents[2] / "docs"


def run(page, replace=("", "")):
    """All names after the page's blocks."""
    blocks = re.findall(r"```python\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block.replace(*replace) if replace[0] else block, page, "exec"), names)
    return names


def test_the_tutorial_and_the_numbers_it_says():
    names = run("tutorial.md")
    np.testing.assert_allclose(names["values"]["B0"].p, [2.001, 5.999], atol=1e-3)
    np.testing.assert_allclose(np.sqrt(np.diag(names["covariance"])[:2]), [0.27, 0.11], atol=0.005)
    assert names["summary"].cost == pytest.approx(73.75, abs=0.005)
    np.testing.assert_allclose(run("tutorial.md", ("cauchy", "huber"))["values"]["B0"].p, [2.15, 5.97], atol=0.005)
    mirrored = run("tutorial.md", ("1.5, 5,", "1, 4,"))
    np.testing.assert_allclose(mirrored["values"]["B0"].p, [1.12, 6.22], atol=0.005)
    assert mirrored["summary"].cost == pytest.approx(73.96, abs=0.005)


@pytest.mark.parametrize("page", ["losses.md", "backends.md", "missing.md", "starts.md"])
def test_a_page_that_helps_to_choose(page):
    run(page).clear()  # a schedule holds its functions, and those the names of the page


def script(name):
    spec = importlib.util.spec_from_file_location(name, DOCS / "site" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def numbers(text):
    return np.array(re.findall(r"\d+\.\d+", text), dtype=float)


def test_the_drawing_of_the_losses_is_that_of_this_library():
    losses = script("losses")
    np.testing.assert_allclose(losses.curves("huber:2", 4), [12, 0.5, 2], rtol=1e-6)
    np.testing.assert_allclose(losses.curves("geman_mcclure:2", -2), [2, 0.25, -0.5], rtol=1e-6)
    np.testing.assert_allclose(numbers((DOCS / "losses.svg").read_text(encoding="utf-8")), numbers(losses.svg()), atol=0.2)


@pytest.mark.skipif("HOLDFAST_DATA" not in os.environ, reason="HOLDFAST_DATA names no folder of data: README's picture was not drawn again")
def test_the_first_picture_is_that_of_this_library():
    drawn = script("first_picture").svg(os.path.join(os.environ["HOLDFAST_DATA"], "range", "plaza2.pyfg"))
    kept = (DOCS / "plaza2.svg").read_text(encoding="utf-8")
    for said in ("least squares: 3.2 m off", "holdfast: 0.28 m off; 180 of 180 lies named"):
        assert said in drawn and said in kept
    np.testing.assert_allclose(numbers(kept), numbers(drawn), atol=0.5)


FIGURES = script("factor_figures")


def test_a_figure_of_a_factor_by_hand():
    swept = FIGURES.FACTORS["range"]
    assert FIGURES.residual(swept, 6.5) == [3] and FIGURES.residual(swept, -4) == [-2]  # 5 m measured, sigma 0.5 m
    assert FIGURES.cost(swept, 6.5, "squared") == 4.5 and FIGURES.cost(swept, 6.5, "huber:2") == 4  # 2 · 3 - 2² / 2


@pytest.mark.parametrize("name", FIGURES.FACTORS)
def test_the_drawing_of_a_factor_is_that_of_this_library(name):
    drawn = (DOCS / "factors" / f"{name}.svg").read_text(encoding="utf-8")
    np.testing.assert_allclose(numbers(drawn), numbers(FIGURES.svg(name)), atol=0.2,
                               err_msg="draw it again: PYTHONPATH=build/release/python python3 docs/site/factor_figures.py docs/factors")
