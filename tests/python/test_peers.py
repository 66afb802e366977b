"""How benchmarks/peers compares: the fastest method of a library that ends at the best cost."""
import importlib.util
import math
import pathlib

PATH = pathlib.Path(__file__).parents[2] / "benchmarks" / "peers" / "same_problems.py"
spec = importlib.util.spec_from_file_location("same_problems", PATH)
peers = importlib.util.module_from_spec(spec)
spec.loader.exec_module(peers)
from results import peer_ratios  # noqa: E402  (of benchmarks/report)


def line(problem, method, seconds, cost):
    return {"problem": problem, "method": method, "seconds": seconds, "cost": cost}


def test_a_method_that_ends_higher_does_not_count():
    lines = [line("a.g2o", "holdfast irls", 2.0, 10.0), line("a.g2o", "GTSAM", 8.0, 10.001),
             line("a.g2o", "GTSAM, Gauss-Newton", 3.0, 20.0), line("a.g2o", "g2o", 1.0, 11.0),
             {"problem": "a.g2o", "method": "SciPy", "left_out": "no wheel"},
             line("b.g2o", "holdfast irls", 1.0, 5.0), line("b.g2o", "g2o", 12.0, 5.0), line("b.g2o", "g2o, dogleg", 1.5, 5.0)]
    found = peer_ratios(lines)
    assert found["a.g2o", "GTSAM"] == 4 and found["a.g2o", "g2o"] == math.inf and found["b.g2o", "g2o"] == 1.5
    assert ("a.g2o", "SciPy") not in found
    assert peers.table(lines).splitlines()[2:] == ["| a | 1.0 | 4.0 | no | – |", "| b | 1.0 | – | 1.5 | – |"]
