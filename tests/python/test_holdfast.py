"""The Python module as its users have it. Run by ctest, or: PYTHONPATH=build/release/python pytest tests/python."""
import copy
import math
import pickle
import signal
import threading

import numpy as np
import pytest

import holdfast as hf

PlaneRange = hf.Range[hf.Point2, hf.Point2]


def trilateration():
    """A point at (3, 4), and three beacons that are known."""
    graph, values = hf.Graph(), hf.Values()
    values.insert("A0", hf.Point2(1.0, 1.0))
    for i, beacon in enumerate([(0, 0), (10, 0), (0, 10)]):
        values.insert(f"L{i}", hf.Point2(*beacon))
        graph.fix(f"L{i}")
        graph.add(PlaneRange(distance=math.dist(beacon, (3, 4)), sigma=0.1), ["A0", f"L{i}"])
    return graph, values


def test_ranges_place_a_point():
    for name in ["irls", "nesterov", "gnc-irls"]:
        graph, values = trilateration()
        assert hf.check(graph, values) == []
        summary = hf.make_backend(name, cost_tolerance=0).solve(graph, values)
        assert summary.usable and summary.cost < 1e-9 < summary.cost_first
        assert graph.cost(values) == summary.cost
        np.testing.assert_allclose(values["A0"].value, [3, 4], atol=1e-6)


def test_keys_are_texts_or_keys():
    key = hf.Agent("r", 1234)(7)
    assert str(key) == "r1234:7" and hf.Key("r1234:7") == key and hf.Key.from_bits(key.bits) == key
    assert pickle.loads(pickle.dumps(key)) == key and len({key, hf.Key("r1234:7")}) == 1
    assert hf.Key("A2") < hf.Key("A11") and hf.Key("A11").agent == hf.Agent("A") and hf.Key("A11").step == 11
    with pytest.raises(hf.BadKey, match="A-1"):
        hf.Key("A-1")


@pytest.mark.parametrize("x", [hf.Pose2(1, 2, 0.5), hf.Pose3.from_roll_pitch_yaw([1, 2, 3], 0.1, 0.2, 0.3), hf.Point3(1, 2, 3),
                               hf.Motion2([1, 2, 3, 4]), hf.Accel3(np.arange(9.0)), hf.Turning2(1, 2, 3, 4, 5), hf.Scalar(7)])
def test_variables_are_manifolds_and_pickle(x):
    delta = np.linspace(0.1, 0.2, x.dim)
    moved = x.retract(delta)
    np.testing.assert_allclose(x.local(moved), delta, atol=1e-12)
    assert pickle.loads(pickle.dumps(moved)) == moved and copy.copy(x) == x != moved
    values = hf.Values()
    values.insert("A0", x)
    assert values["A0"] == x and "A0" in values and len(values) == 1
    values.update("A0", moved)
    assert values["A0"] == moved


def test_pose_algebra():
    pose = hf.Pose2(1, 2, math.pi / 2) * hf.Pose2(1, 0, 0)
    np.testing.assert_allclose([*pose.p, pose.angle], [1, 3, math.pi / 2])
    assert hf.Pose3([0, 0, 0], [0, 0, 0, 1]) == hf.Pose3()
    with pytest.raises(hf.BadNumber, match="length"):
        hf.Pose3([0, 0, 0], [0, 0, 0, 2])


def test_errors_name_the_culprit():
    graph, values = trilateration()
    for wrong, error, said in [
        (lambda: values["Q7"], hf.BadKey, "Q7"),
        (lambda: values.update("A0", hf.Pose2()), hf.BadType, "A0"),
        (lambda: values.insert("A0", hf.Point2()), hf.BadKey, "A0"),
        (lambda: values.insert("A1", 3.0), TypeError, "insert"),
        (lambda: hf.Point2(1, 2, 3), TypeError, "2 numbers"),
        (lambda: graph.add(PlaneRange(5, -1), ["A0", "L0"]), hf.BadNumber, "sigma"),
        (lambda: graph.add(PlaneRange(math.nan, 1), ["A0", "L0"]), hf.BadNumber, "distance"),
        (lambda: graph.add(PlaneRange(5, 1), ["A0"]), hf.BadKey, "2 variables"),
        (lambda: graph.add(PlaneRange(5, 1), ["A0", "A0"]), hf.BadKey, "twice"),
        (lambda: graph.add(PlaneRange(5, 1), ["A0", "L0"], loss="hubber:2"), (hf.BadOption, TypeError), "hubber|incompatible"),
        (lambda: graph.add(3.0, ["A0"]), TypeError, "no factor"),
        (lambda: PlaneRange(5), TypeError, "sigma"),
        (lambda: PlaneRange(5, 1, colour=3), TypeError, "more arguments"),
        (lambda: PlaneRange("far", 1), TypeError, "distance"),
        (lambda: hf.Range[hf.Point2, hf.Point3], TypeError, "there are"),
        (lambda: hf.make_backend("magic"), hf.BadOption, "magic"),
        (lambda: hf.make_backend(threads=0), hf.BadOption, "threads"),
        (lambda: hf.read_problem("no-such-file.g2o"), hf.BadFile, "no-such-file"),
        (lambda: hf.make_backend().solve(hf.Graph(), values), hf.BadProblem, "no factors"),
    ]:
        with pytest.raises(error, match=said):
            wrong()
    assert len(graph) == 3 and len(values) == 4


def test_add_many_is_all_or_nothing():
    graph, values = trilateration()
    keys = np.array([[hf.Key("A0").bits, hf.Key(f"L{i}").bits] for i in range(3)], dtype=np.uint64)
    ids = graph.add_many(PlaneRange, keys, np.array([5.0, 6.0, 7.0]), 0.1, loss="huber:2")
    assert len(ids) == 3 and len(graph) == 6 and graph.factors_on("L1")[-1].number == ids[1].number
    np.testing.assert_allclose(graph.residual(ids[0], values), [(math.sqrt(2) - 5) / 0.1])
    with pytest.raises(hf.BadNumber):
        graph.add_many(PlaneRange, keys, [5.0, -6.0, 7.0], 0.1)
    with pytest.raises(ValueError, match="field of 2"):
        graph.add_many(PlaneRange, keys, [5.0, 6.0], 0.1)
    assert len(graph) == 6


def test_a_weight_a_loss_and_a_factor_that_goes():
    graph, values = trilateration()
    id = graph.add(hf.Prior[hf.Point2].from_sigmas(hf.Point2(0, 0), [1, 1]), "A0", weight=3.0)
    assert graph.cost(values) - trilateration()[0].cost(values) == pytest.approx(0.5 * 3 * 2)
    graph.set_weight(id, 1.0)
    graph.set_loss(id, "huber:1")
    assert graph.cost(values) - trilateration()[0].cost(values) == pytest.approx(0.5 * (2 * math.sqrt(2) - 1))
    graph.remove(id)
    assert id not in graph
    with pytest.raises(hf.BadKey):
        graph.remove(id)


def test_a_lie_is_reported():
    graph, values = trilateration()
    lie = graph.add(PlaneRange(distance=25, sigma=0.1), ["A0", "L0"], loss="truncated_squares:3")
    assert hf.make_backend("gnc-irls").solve(graph, values).usable
    outliers = [one for one in hf.outlier_report(graph, values) if one.verdict == "outlier"]
    assert [one.id.number for one in outliers] == [lie.number]
    assert outliers[0].raw == pytest.approx([-20], abs=0.1) and outliers[0].keys == [hf.Key("A0"), hf.Key("L0")]


def test_every_factor_is_made_of_its_fields():
    plain = {"double": 1.0, "int32": 1, "enum int32": 0}
    made = 0
    for name in dir(hf._core):
        factor = getattr(hf._core, name)
        if not hasattr(factor, "_add") or "Pose2[" in factor.fields or "Pose3[" in factor.fields or "Point" in factor.fields:
            continue
        fields = dict(one.split(" ", 1) for one in factor.fields.split(", "))
        given = {}
        for field, type_ in fields.items():
            if type_ in plain:
                given[field] = plain[type_]
            elif type_.startswith("double["):
                given[field] = np.ones([int(n) for n in type_[7:-1].split("x")]).squeeze(-1 if type_.endswith("x1]") else ())
        if len(given) < len(fields):
            continue
        one = factor(**given)
        for field, value in given.items():
            np.testing.assert_array_equal(np.squeeze(getattr(one, field)), np.squeeze(value))
        made += 1
    assert made >= 20


def test_marginals():
    graph, values = hf.Graph(), hf.Values()
    values.insert("A0", hf.Pose2())
    graph.add(hf.Prior[hf.Pose2].from_sigmas(hf.Pose2(), [1, 2, 0.5]), "A0")
    np.testing.assert_allclose(hf.Marginals(graph, values).covariance("A0"), np.diag([1, 4, 0.25]), atol=1e-12)


def test_a_file(tmp_path):
    path = tmp_path / "three.g2o"
    path.write_text("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.2 0 0\nVERTEX_SE2 2 2.1 0 0\n"
                    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n")
    graph, values = hf.read_problem(str(path), loss="cauchy:1")
    assert len(graph) == 2 and graph.is_fixed("x0")
    assert hf.make_backend().solve(graph, values).usable
    np.testing.assert_allclose(values["x2"].p, [2, 0], atol=1e-6)


def test_many_threads_solve_at_once():
    graph, _ = trilateration()
    answers = []

    def work():
        values = trilateration()[1]
        hf.make_backend(threads=2).solve(graph, values)
        answers.append(tuple(values["A0"].value))

    threads = [threading.Thread(target=work) for _ in range(8)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert len(answers) == 8 and len(set(answers)) == 1


def test_ctrl_c_stops_a_solve_and_values_stay():
    graph, values = hf.Graph(), hf.Values()
    graph.add(hf.Prior[hf.Point2].from_sigmas(hf.Point2(0, 0), [1, 1]), "A0")
    values.insert("A0", hf.Point2(3, 3))
    for i in range(2000):
        values.insert(f"A{i + 1}", hf.Point2(i * i % 97, i % 13))
        graph.add(PlaneRange(7.0, 0.1), [f"A{i}", f"A{i + 1}"], loss="cauchy:1")
        graph.add(PlaneRange(2.0, 0.1), [f"A{i * 7 % (i + 1)}", f"A{i + 1}"], loss="cauchy:1") if i % 7 else None
    before = values["A0"]

    def stop(*_):
        raise KeyboardInterrupt

    old = signal.signal(signal.SIGALRM, stop)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with pytest.raises(KeyboardInterrupt):
            hf.make_backend("nesterov", max_iterations=10**9, cost_tolerance=0, gradient_tolerance=0, time_limit=60).solve(graph, values)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, old)
    assert values["A0"] == before


def test_what_is_wrong_with_a_loss_or_a_key_is_said():
    graph = hf.Graph()
    factor = hf.Range[hf.Pose2, hf.Point2](distance=1, sigma=0.1)
    with pytest.raises(hf.BadOption, match="hubber"):
        graph.add(factor, ["A0", "L0"], loss="hubber:2")
    with pytest.raises(hf.Error, match="key"):
        graph.add(factor, ["A0", ""])
    with pytest.raises(hf.BadOption, match="hubber"):
        graph.add_many(hf.Range[hf.Pose2, hf.Point2], [["A0", "L0"]], [1.0], 0.1, loss="hubber:2")
    assert len(graph) == 0


def test_a_number_for_all_may_be_an_array_without_dimensions():
    graph = hf.Graph()
    graph.add_many(hf.Range[hf.Pose2, hf.Point2], [["A0", "L0"], ["A1", "L0"]], np.array(1.0), 0.1)
    assert len(graph) == 2


def test_two_threads_do_not_share_a_back_end_or_values():
    graph, start, A = hf.Graph(), hf.Values(), hf.Agent("A")
    n = 3000
    for k in range(n):
        start.insert(A(k), hf.Pose2(k, 0.1 * (k % 3), 0))
    graph.add(hf.Prior[hf.Pose2].from_sigmas(hf.Pose2(0, 0, 0), [0.1, 0.1, 0.1]), [A(0)])
    for k in range(1, n):
        graph.add(hf.Between[hf.Pose2].from_sigmas(hf.Pose2(1, 0, 0), [0.1, 0.1, 0.1]), [A(k - 1), A(k)])
    backend, shared = hf.make_backend("nesterov", max_iterations=300), hf.Values(start)
    ended, refused = [], []
    gate = threading.Barrier(6)

    def solve(own_backend, values):
        gate.wait()
        try:
            ended.append(own_backend.solve(graph, values).usable)
        except hf.BadProblem as error:
            refused.append(str(error))

    threads = [threading.Thread(target=solve, args=(backend, hf.Values(start))) for _ in range(3)]
    threads += [threading.Thread(target=solve, args=(hf.make_backend("irls"), shared)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(ended) + len(refused) == 6 and all(ended) and len(ended) >= 2
    assert refused and all("another thread is solving" in text for text in refused)
    assert backend.solve(graph, hf.Values(start)).usable  # it is free again
