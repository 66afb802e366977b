"""Python functions as factors, and the incremental smoother."""
import gc
import math
import sys
import threading
import weakref

import holdfast as hf
import numpy as np
import pytest


def problem():
    """Poses with priors that range to three points: graph, values, keys and distances."""
    rng = np.random.default_rng(1)
    graph, values = hf.Graph(), hf.Values()
    points = rng.uniform(-10, 10, (3, 2))
    for j, p in enumerate(points):
        values.insert(f"L{j}", hf.Point2(*p))
    keys, distances = [], []
    for i in range(40):
        x, y, t = rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-3, 3)
        values.insert(f"x{i}", hf.Pose2(x, y, t))
        graph.add(hf.Prior[hf.Pose2].from_sigmas(hf.Pose2(x, y, t), [0.5, 0.5, 0.1]), [f"x{i}"])
        for j, p in enumerate(points):
            keys.append([f"x{i}", f"L{j}"])
            distances.append(math.hypot(*(p - [x, y])) + rng.uniform(-0.3, 0.3))
    return graph, values, keys, np.array(distances)


def ranges(distances):
    def residual(which, pose, point):
        return (np.linalg.norm(point - pose[:, :2], axis=1) - distances[which]) / 0.1

    return residual


def ranges_with_jacobian(distances):
    def residual(which, pose, point):
        x = point - pose[:, :2]
        d = np.linalg.norm(x, axis=1)
        u = x / d[:, None] / 0.1
        return (d - distances[which]) / 0.1, np.c_[-u, np.zeros(len(d))][:, None, :], u[:, None, :]

    return residual


def cost_with_factors(loss):
    graph, values, keys, distances = problem()
    graph.add_many(hf.Range[hf.Pose2, hf.Point2], keys, distances, 0.1, loss=loss)
    return hf.make_backend("irls", cost_tolerance=1e-12).solve(graph, values).cost


@pytest.mark.parametrize("loss", ["squared", "huber:2"])
@pytest.mark.parametrize("name", ["irls", "nesterov", "gnc-irls"])
def test_every_backend_ends_where_the_factors_do(name, loss):
    expected = cost_with_factors(loss)
    for jacobian in (False, True):
        graph, values, keys, distances = problem()
        function = (ranges_with_jacobian if jacobian else ranges)(distances)
        graph.add_function(function, [hf.Pose2, hf.Point2], keys, 1, loss=loss, jacobian=jacobian)
        end = hf.make_backend(name, cost_tolerance=1e-12, threads=2).solve(graph, values)
        assert end.usable, end
        assert end.cost == pytest.approx(expected, rel=1e-5)


def test_factor_by_factor():
    graph, values, keys, distances = problem()

    def one(which, pose, point):
        return (math.hypot(*(point - pose[:2])) - distances[which]) / 0.1

    graph.add_function(one, [hf.Pose2, hf.Point2], keys, 1, vectorized=False)
    assert hf.make_backend("irls", cost_tolerance=1e-12).solve(graph, values).cost == pytest.approx(cost_with_factors("squared"), rel=1e-5)


def test_an_exception_ends_the_solve_and_the_values_stay():
    graph, values, keys, distances = problem()
    graph.add_function(lambda which, pose, point: 1 / 0, [hf.Pose2, hf.Point2], keys, 1, name="Broken")
    before = repr(values)
    end = hf.make_backend("irls").solve(graph, values)
    assert end.termination == "failed"
    assert "Broken" in end.why and "ZeroDivisionError" in end.why
    assert repr(values) == before


@pytest.mark.parametrize("bad, said", [
    (lambda which, pose, point: np.zeros((len(which), 2)), "shape"),
    (lambda which, pose, point: "nothing", "could not convert"),
    (lambda which, pose, point: None, "shape"),
    (lambda which: 0, "positional argument"),
    (lambda which, pose, point: np.full(len(which), np.nan), "not finite"),
])
def test_wrong_shapes_and_types_are_said(bad, said):
    graph, values, keys, _ = problem()
    graph.add_function(bad, [hf.Pose2, hf.Point2], keys, 1)
    end = hf.make_backend("irls").solve(graph, values)
    assert end.termination == "failed"
    assert said in end.why


def test_ctrl_c_in_a_function_stops_the_solve():
    graph, values, keys, distances = problem()

    def interrupted(which, pose, point):
        raise KeyboardInterrupt

    graph.add_function(interrupted, [hf.Pose2, hf.Point2], keys, 1)
    before = repr(values)
    with pytest.raises(KeyboardInterrupt):
        hf.make_backend("irls").solve(graph, values)
    assert repr(values) == before


def test_what_it_raises_elsewhere_is_raised_there_and_forgotten():
    graph, values, keys, distances = problem()
    state = {"bad": True}

    def moody(which, pose, point):
        if state["bad"]:
            raise ValueError("not now")
        return ranges(distances)(which, pose, point)

    graph.add_function(moody, [hf.Pose2, hf.Point2], keys, 1, name="Moody")
    for what in (lambda: graph.cost(values), lambda: hf.Marginals(graph, values), lambda: hf.outlier_report(graph, values)):
        with pytest.raises(RuntimeError, match="(?s)Moody.*not now|not finite"):
            what()
    state["bad"] = False
    assert hf.make_backend("irls").solve(graph, values).usable


def test_other_threads_may_evaluate_the_graph_during_a_solve():
    graph, values, keys, distances = problem()
    ids = graph.add_function(ranges(distances), [hf.Pose2, hf.Point2], keys, 1)
    start = hf.Values(values)
    failures = []

    def evaluate():
        try:
            for _ in range(50):
                graph.residual(ids[0], start)
                graph.cost(start)
        except Exception as error:  # pylint: disable=broad-except
            failures.append(error)

    threads = [threading.Thread(target=evaluate, daemon=True) for _ in range(2)]
    for thread in threads:
        thread.start()
    for _ in range(5):
        hf.make_backend("irls").solve(graph, hf.Values(start))
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    assert not failures


def test_a_function_that_evaluates_its_own_graph_is_refused():
    graph, values, keys, distances = problem()
    graph.add_function(lambda which, pose, point: np.full(len(which), graph.cost(values)), [hf.Pose2, hf.Point2], keys, 1)
    end = hf.make_backend("irls").solve(graph, values)
    assert end.termination == "failed" and "its own factors" in end.why


def test_a_copy_that_only_the_function_holds_lives_as_long_as_it():
    graph, values, keys, distances = problem()
    holder = {}

    def residual(which, pose, point, holder=holder):
        return ranges(distances)(which, pose, point)

    graph.add_function(residual, [hf.Pose2, hf.Point2], keys, 1)
    holder["copy"] = hf.Graph(graph)
    del graph
    gc.collect()
    assert residual(np.arange(2), np.ones((2, 4)), np.zeros((2, 2))).shape == (2,)
    assert hf.make_backend("irls").solve(holder["copy"], values).usable


def test_what_is_no_function_is_refused():
    graph = hf.Graph()
    with pytest.raises(TypeError):
        graph.add_function(3, [hf.Pose2], [["x0"]], 1)
    with pytest.raises(TypeError):
        graph.add_function(lambda *a: 0, [int], [["x0"]], 1)
    with pytest.raises(hf.BadKey):
        graph.add_function(lambda *a: 0, [hf.Pose2], [["x0", "x1"]], 1)
    with pytest.raises(hf.BadOption):
        graph.add_function(lambda *a: 0, [hf.Pose2], [["x0"]], 0)
    assert len(graph) == 0


def test_references_are_let_go():
    graph, values, keys, distances = problem()
    function = ranges(distances)
    count = sys.getrefcount(function)
    graph.add_function(function, [hf.Pose2, hf.Point2], keys, 1)
    for _ in range(50):
        hf.make_backend("gnc-irls").solve(hf.Graph(graph), hf.Values(values))
    del graph
    gc.collect()
    assert sys.getrefcount(function) == count


def test_a_graph_that_its_function_holds_is_collected():
    class Holder:
        pass

    gone = []
    for _ in range(3):
        holder = Holder()
        holder.graph = hf.Graph()
        holder.graph.add_function(lambda which, pose, holder=holder: pose[:, :1], [hf.Pose2], [["x0"]], 1)
        gone.append(weakref.ref(holder))
    del holder
    gc.collect()
    assert [one() for one in gone] == [None] * 3


def test_positions_and_plot(tmp_path):
    pytest.importorskip("plotly")
    _, values, _, _ = problem()
    tracks = hf.positions(values)
    assert tracks["x"][0].shape == (40, 2) and tracks["L"][0].shape == (3, 2)
    hf.plot(values, tmp_path / "a.html")
    assert "plotly" in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_incremental_is_the_batch_answer():
    smoother = hf.Incremental()
    smoother.insert("x0", hf.Pose2(0, 0, 0))
    smoother.add(hf.Prior[hf.Pose2].from_sigmas(hf.Pose2(0, 0, 0), [0.1, 0.1, 0.05]), ["x0"])
    step = hf.Pose2(1, 0, 0.3)
    for k in range(1, 20):
        smoother.insert(f"x{k}", smoother.at(f"x{k - 1}") * step)
        smoother.add(hf.Between[hf.Pose2].from_sigmas(step, [0.05, 0.05, 0.02]), [f"x{k - 1}", f"x{k}"])
        if k == 19:
            smoother.add(hf.Between[hf.Pose2].from_sigmas(hf.Pose2(-1, 0, 5.9), [0.05, 0.05, 0.02]), ["x0", "x19"], loss="huber:2")
        smoother.update()
    smoother.finish()
    values = smoother.values()
    end = hf.make_backend("irls", cost_tolerance=1e-12).solve(smoother.graph, values)
    assert smoother.cost() == pytest.approx(end.cost, rel=1e-6)
    assert smoother.covariance([hf.Key("x19")]).shape == (3, 3)
    smoother.insert("L0", hf.Point2(1, 2))
    with pytest.raises(hf.Underdetermined, match="L0"):
        smoother.add(hf.Range[hf.Pose2, hf.Point2](2.0, 0.1), ["x0", "L0"])
        smoother.update()


def test_summary_says_what_is_known_of_the_end():
    graph, values = hf.Graph(), hf.Values()
    for i, p in enumerate([(0, 0), (10, 0), (5, 0)]):
        values.insert(f"L{i}", hf.Point2(*p))
        graph.fix(hf.Key(f"L{i}"))
        graph.add(hf.Range[hf.Point2, hf.Point2](5.0 if i == 2 else 7.07, 0.1), ["N0", f"L{i}"])
    values.insert("N0", hf.Point2(5.5, 0))
    end = hf.make_backend("irls", second_order=True, findings=True, trace=True).solve(graph, values)
    assert end.minimum == "left a saddle" and end.saddles_left == 1
    assert [f.kind for f in end.findings] == ["mirror image"]
    assert end.trace and not end.is_convex


def test_a_saved_incremental_goes_on_with_the_same_bits(tmp_path):
    def walk(smoother, k):
        if k == 0:
            smoother.insert("x0", hf.Pose2(0, 0, 0))
            smoother.add(hf.Prior[hf.Pose2].from_sigmas(hf.Pose2(0, 0, 0), [0.1, 0.1, 0.02]), ["x0"])
        else:
            step = hf.Pose2(0.5, 0, 0.1)
            smoother.insert(f"x{k}", smoother.at(f"x{k - 1}") * step)
            smoother.add(hf.Between[hf.Pose2].from_sigmas(step, [0.1, 0.1, 0.02]), [f"x{k - 1}", f"x{k}"])
            if k > 20:
                smoother.add(hf.Between[hf.Pose2].from_sigmas(hf.Pose2(0.3, 0.2, 2), [0.1, 0.1, 0.02]), [f"x{k - 20}", f"x{k}"])
        return smoother.update()

    one, other = hf.Incremental(report=True), hf.Incremental()
    for k in range(30):
        assert len(walk(one, k).report) >= 1
    one.save(str(tmp_path / "state"), b"step 30")
    assert other.restore(str(tmp_path / "state")) == b"step 30"
    for k in range(30, 50):
        walk(one, k)
        walk(other, k)
    assert one.cost() == other.cost()
    with pytest.raises(hf.BadFile):
        other.restore(str(tmp_path / "nothing"))
