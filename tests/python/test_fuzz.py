"""The module under random calls, a few seconds of tests/python/fuzz_module.py; and what a solve with Python factors leaves behind."""
import gc
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import holdfast as hf

FUZZ = pathlib.Path(__file__).parent / "fuzz_module.py"


def test_random_calls_do_not_crash():
    pytest.importorskip("hypothesis")
    done = subprocess.run([sys.executable, "-X", "faulthandler", str(FUZZ), "--seconds", "4"], capture_output=True, text=True, check=False,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    assert done.returncode == 0 and "none crashed" in done.stdout, done.stdout[-500:] + done.stderr[-3000:]


def solve_with_python_factors(n):
    """n small solves: of functions that give Jacobians or do not, that raise now and then, in graphs that go at once."""
    def residual(which, a):
        if residual.broken:
            raise ValueError("no")
        return a - 1.0

    def with_jacobian(which, a):
        return a - 1.0, np.broadcast_to(np.eye(2), (len(a), 2, 2))

    backend = hf.make_backend("irls")
    for i in range(n):
        residual.broken = i % 7 == 0
        graph, values = hf.Graph(), hf.Values()
        values.insert("A0", hf.Point2(0, 0))
        graph.add_function(residual, [hf.Point2], [["A0"]], 2)
        graph.add_function(with_jacobian, [hf.Point2], [["A0"]], 2, loss="huber:2", jacobian=True)
        assert backend.solve(graph, values).usable != residual.broken


def resident():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096


def count_left_behind(solves):
    """Python objects and bytes that so many solves leave, after some have warmed up."""
    solve_with_python_factors(500)
    gc.collect()
    objects, bytes_ = len(gc.get_objects()), resident()
    references = [sys.getrefcount(one) for one in (None, True, hf.Point2, hf.Graph, 0)]
    solve_with_python_factors(solves)
    gc.collect()
    grown = [now - before for now, before in zip([sys.getrefcount(one) for one in (None, True, hf.Point2, hf.Graph, 0)], references)]
    return len(gc.get_objects()) - objects, resident() - bytes_, max(map(abs, grown))


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="no /proc here that says how much memory is resident")
def test_solves_with_python_factors_leave_nothing():
    objects, bytes_, references = count_left_behind(2000)
    assert objects < 50 and bytes_ < 4e6 and references < 200, (objects, bytes_, references)


if __name__ == "__main__":  # the number of solves as an argument
    print("left: %d objects, %d bytes, %d references" % count_left_behind(int(sys.argv[1])))
