"""Losses that are Python functions or classes."""
import math
import pickle

import holdfast as hf
import numpy as np
import pytest


def cauchy(s):
    return 4 * math.log1p(s / 4), 1 / (1 + s / 4), -0.25 / (1 + s / 4) ** 2


class Fair:
    """ρ = 2c² (u − ln(1 + u)), u = √s / c"""

    is_convex = True

    def __init__(self, c):
        self.c = c

    def rho(self, s):
        root = math.sqrt(s)
        u = root / self.c
        return 2 * self.c**2 * (u - math.log1p(u)), 1 / (1 + u), -0.5 / (self.c * root * (1 + u) ** 2) if s > 0 else 0


def beacon(loss, echo=0.0):
    """A beacon seen from five places, once by way of a wall."""
    graph, values = hf.Graph(), hf.Values()
    values.insert("L0", hf.Point2(2, 1))
    for k in range(5):
        values.insert(f"A{k}", hf.Point2(k, 0.2 * k * k))
        graph.fix(f"A{k}")
        distance = math.hypot(3 - k, 2 - 0.2 * k * k) + (echo if k == 0 else 0)
        graph.add(hf.Range[hf.Point2, hf.Point2](distance, 0.1), [f"A{k}", "L0"], loss=loss)
    return graph, values


def solved(loss, backend="irls", echo=3.0, **options):
    graph, values = beacon(loss, echo)
    summary = hf.make_backend(backend, cost_tolerance=1e-14, **options).solve(graph, values)
    assert summary.usable, summary
    return graph.cost(values), np.array(values["L0"].position)


@pytest.mark.parametrize("backend", ["irls", "nesterov", "gnc-irls"])
def test_a_function_ends_where_the_same_loss_of_cpp_does(backend):
    cost, where = solved(hf.own_loss(cauchy), backend)
    expected, there = solved(hf.Cauchy(2), backend)
    assert cost == pytest.approx(expected, rel=1e-9)
    assert where == pytest.approx(there, abs=1e-5)


def test_an_object_says_its_name_and_whether_it_is_convex():
    loss = hf.own_loss(Fair(1.4))
    assert loss.is_convex and "Fair" in repr(loss)
    assert not hf.own_loss(cauchy).is_convex
    assert "mine" in repr(hf.own_loss(cauchy, name="mine"))
    assert loss.rho(2.0) == pytest.approx(Fair(1.4).rho(2.0))
    assert solved(loss, echo=0)[1] == pytest.approx([3, 2], abs=1e-6)


def test_flags_and_equality_are_those_of_every_loss():
    fair = Fair(1.4)
    assert hf.own_loss(fair) == hf.own_loss(fair)
    assert hf.own_loss(fair) != hf.own_loss(Fair(1.4))
    assert hf.per_component(hf.own_loss(fair)) != hf.own_loss(fair)
    graph, values = beacon(hf.one_sided(hf.own_loss(cauchy)), echo=-3)       # too short: squared
    squared, _ = beacon("squared", echo=-3)
    values.update("L0", hf.Point2(3, 2))
    assert graph.cost(values) == pytest.approx(squared.cost(values))


@pytest.mark.parametrize(
    "wrong, says",
    [
        (lambda s: (2 * s, 2.0, 0.0), "rho'(0) = 2"),
        (lambda s: (s + 1, 1.0, 0.0), "rho(0) = 1"),
        (lambda s: (math.log1p(s), 1.0, 0.0), "rho'"),
    ],
)
def test_a_loss_that_breaks_the_contract_is_refused_by_what_it_breaks(wrong, says):
    with pytest.raises(hf.BadNumber, match=says.replace("(", r"\(").replace(")", r"\)")):
        hf.own_loss(wrong)
    hf.own_loss(wrong, check=False)


def test_wrong_results_and_types_are_refused():
    with pytest.raises(RuntimeError, match="3 numbers, not 2"):
        hf.own_loss(lambda s: (s, 1))
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        hf.own_loss(lambda s: (s, 1 / s, 0))
    with pytest.raises(TypeError, match="a function is needed"):
        hf.own_loss(3)


def test_what_it_raises_fails_the_solve_and_leaves_the_values():
    calls = []

    def tires(s):
        calls.append(s)
        if len(calls) > 20:
            raise ValueError("tired of it")
        return s, 1.0, 0.0

    graph, values = beacon(hf.own_loss(tires, check=False))
    before = values["L0"].position
    summary = hf.make_backend("irls").solve(graph, values)
    assert not summary.usable and "tired of it" in summary.why
    assert np.array_equal(values["L0"].position, before)
    with pytest.raises(RuntimeError, match="tired of it"):
        graph.cost(values)


def test_it_is_refused_where_it_would_be_saved():
    with pytest.raises(hf.BadOption, match="cauchy"):
        pickle.dumps(hf.own_loss(cauchy))
