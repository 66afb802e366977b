"""scripts/attack_window: it changes the ranges of the bursts and nothing else, and its scores are those one finds by hand."""
import importlib.machinery
import importlib.util
import pathlib
import random

import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "attack_window"
loader = importlib.machinery.SourceFileLoader("attack_window", str(SCRIPT))
attack_window = importlib.util.module_from_spec(importlib.util.spec_from_loader("attack_window", loader))
loader.exec_module(attack_window)

LINES = [["VERTEX_SE2", "0.0", "A0", "0", "0", "0"]] + [["EDGE_RANGE", repr(float(t)), f"A{t}", "L0", "40.0", "0.25"] for t in range(100)]


def test_bursts_are_apart_and_inside_the_file():
    for seed in range(50):
        bursts = attack_window.intervals("uniform:15", 0, 400, random.Random(seed))
        assert len(bursts) == 4
        assert all(end - begin == pytest.approx(15) for begin, end in bursts)
        assert all(a[1] <= b[0] for a, b in zip(bursts, bursts[1:]))
        assert bursts[0][0] >= 0 and bursts[-1][1] <= 400


@pytest.mark.parametrize("attack", ["fog:3", "uniform", "uniform:90"])
def test_an_attack_that_is_none_ends_the_program(attack):
    with pytest.raises(SystemExit):
        attack_window.intervals(attack, 0, 400, random.Random(0))


def test_only_ranges_of_the_burst_change():
    for attack in ("uniform:10", "biased:10"):
        changed = [line.split() for line in attack_window.attacked(LINES, attack, [(20, 30)], random.Random(1))]
        assert [w for w in changed if not 20 <= float(w[1]) <= 30 or w[0] != "EDGE_RANGE"] == [
            w for w in LINES if not 20 <= float(w[1]) <= 30 or w[0] != "EDGE_RANGE"]
        lies = [float(w[4]) for w in changed if w[0] == "EDGE_RANGE" and 20 <= float(w[1]) <= 30]
        assert len(lies) == 11 and 40.0 not in lies
        assert (len(set(lies)) == 1) == attack.startswith("biased")
        assert all(0 <= lie <= 100 for lie in lies)
    silent = list(attack_window.attacked(LINES, "silent:10", [(20, 30)], random.Random(1)))
    assert len(silent) == len(LINES) - 11


def test_scores_by_hand():
    truth = {"A0": [0, 0], "A1": [0, 0], "A2": [0, 0], "A3": [0, 0]}
    states = [{"t": t, "key": f"A{i}", "p": [x, 0]} for i, (t, x) in enumerate([(5, 0.5), (12, 3), (21, 9), (23, 1)])]
    said = [(12.0, "A", None), (21.0, None, "A")]
    # A2 is within the 2 s that it has after the burst: it counts nowhere
    assert attack_window.scored(states, truth, [(10, 20)], said) == (3, 1, 1, False)
    assert attack_window.scored(states, truth, [(10, 20)], said[:1]) == (3, 1, 1, True)
    assert attack_window.scored(states, truth, [(10, 20)], []) == (3, 1, 0, False)
