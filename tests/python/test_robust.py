"""GNC's options, certificates, consistent loops, starts, progress, options, columns, files: what C++ has, from Python."""
import copy
import gc
import math
import pickle
import threading

import numpy as np
import pytest

import holdfast as hf

Between, Prior = hf.Between[hf.Pose2], hf.Prior[hf.Pose2]


def ring(n=24, false_loops=0, loss=None):
    """A ring of poses, loop closures across it, and false ones; the ids of both."""
    graph, values, rng = hf.Graph(), hf.Values(), np.random.default_rng(7)
    poses = [hf.Pose2(10 * math.cos(2 * math.pi * k / n), 10 * math.sin(2 * math.pi * k / n), 2 * math.pi * k / n) for k in range(n)]
    for k, pose in enumerate(poses):
        values.insert(f"x{k}", pose.retract(0.02 * rng.standard_normal(3)))
    graph.fix("x0")
    values.update("x0", poses[0])
    noise = [0.05, 0.05, 0.01]

    def relative(a, b):
        return (poses[a].inverse() * poses[b]).retract(0.3 * np.array(noise) * rng.standard_normal(3))

    for k in range(n - 1):
        graph.add(Between.from_sigmas(relative(k, k + 1), noise), [f"x{k}", f"x{k + 1}"])
    true = [graph.add(Between.from_sigmas(relative(k, k + n // 2), noise), [f"x{k}", f"x{k + n // 2}"], loss=loss) for k in range(n // 2)]
    lies = [hf.Pose2(*rng.uniform(-20, 20, 2), rng.uniform(-3, 3)) for _ in range(false_loops)]
    false = [graph.add(Between.from_sigmas(lies[k], noise), [f"x{k}", f"x{k + 5}"], loss=loss)
             for k in range(false_loops)]
    return graph, values, true, false


def test_gnc_with_its_options():
    graph, values, true, false = ring(false_loops=4, loss=hf.TruncatedSquares(4))
    backend = hf.gnc(hf.make_backend("irls", threads=2), mu_factor=1.4, known_inliers=true[:2], second_chances=False)
    assert backend.name == "gnc-irls" and backend.mu_factor == 1.4 and backend.options.threads == 2
    assert backend.solve(graph, values).usable
    assert all(backend.weight(id) > 0.9 for id in true) and all(backend.weight(id) < 0.1 for id in false)
    assert set(backend.weights) == set(true + false)
    with pytest.raises(hf.BadOption, match="mu_factor"):
        hf.gnc(hf.make_backend("irls"), mu_factor=0.5)
    assert copy.copy(backend).mu_factor == 1.4


def test_a_certificate():
    graph, values, _, _ = ring()
    assert hf.make_backend("irls", cost_tolerance=0).solve(graph, values).usable
    found = hf.certify(graph, values)
    assert found.is_global and found.bound <= found.cost and found.left_out == 0 and found.relative_gap < 1e-7
    values.update("x3", values["x3"].retract([5, 5, 1]))
    assert not hf.certify(graph, values).is_global
    with pytest.raises(hf.BadOption, match="tolerance"):
        hf.certify(graph, values, tolerance=-1)


def test_loops_that_agree():
    graph, values, true, false = ring(n=40, false_loops=3)
    found = hf.consistent_loops(graph)
    assert set(false) <= set(found.rejected) and len(set(true) & set(found.kept)) > len(true) / 2
    for id in found.rejected:
        graph.remove(id)
    hf.make_backend("irls").solve(graph, values)
    graph, _, true, false = ring(n=40, false_loops=3)
    assert hf.agreeing_loops(graph, values, false) == []
    with pytest.raises(hf.BadOption):
        hf.consistent_loops(graph, false_alarm=2)


def test_ranges_that_agree():
    graph, rng = hf.Graph(), np.random.default_rng(5)
    here, beacon, true, false = hf.Pose2(0, 0, 0), np.array([4.0, 9.0]), [], []
    for k in range(80):
        if k > 0:
            step = hf.Pose2(0.5, 0, 0.3 * math.sin(0.1 * k))
            here = here * step
            graph.add(Between.from_sigmas(step, [0.01, 0.01, 0.002]), [f"x{k - 1}", f"x{k}"])
        echo = k % 3 == 0
        distance = float(np.linalg.norm(beacon - here.p) + 0.1 * rng.standard_normal() + (rng.uniform(1, 10) if echo else 0))
        (false if echo else true).append(graph.add(hf.Range[hf.Pose2, hf.Point2](distance, 0.1), [f"x{k}", "L0"]))
    found = hf.consistent_ranges(graph)
    assert set(found.rejected) == set(false) and set(found.kept) == set(true)
    assert found.untested == 0 and found.groups == 1 and found.decided == found.windows and "53 of 80 ranges" in str(found)
    with pytest.raises(hf.BadOption, match="window"):
        hf.consistent_ranges(graph, window=2)


def test_starts():
    graph, values, _, _ = ring()
    lost = hf.Values(values)
    for key in values:
        lost.update(key, values[key] if str(key) == "x0" else hf.Pose2(0, 0, 3))
    assert hf.chordal_start(graph, lost)
    assert graph.cost(lost) < 10 * graph.cost(values)
    points, start = hf.Graph(), hf.Values()
    for i, place in enumerate([(0, 0), (10, 0), (0, 10)]):
        start.insert(f"L{i}", hf.Point2(*place))
        points.fix(f"L{i}")
        points.add(hf.RangeBall[hf.Point2, hf.Point2](math.dist(place, (3, 4)), 0.1), ["A0", f"L{i}"])
    start.insert("A0", hf.Point2(500, -900))
    found, refined = hf.convex_start(points, start, hf.make_backend("irls"))
    assert found.is_convex and refined.usable
    np.testing.assert_allclose(start["A0"].value, [3, 4], atol=1e-2)
    start.update("A0", hf.Point2(500, -900))
    options = hf.Options()
    options.cost_tolerance = 0
    assert hf.relaxed_start(points, start, options).relaxed.usable


def test_progress_stops_a_solve_or_ends_it_by_what_it_raises():
    graph, values, _, _ = ring()
    for key in list(values)[1:]:
        values.update(key, hf.Pose2(0, 0, 0))
    seen = []
    summary = hf.make_backend("nesterov", progress=lambda i: seen.append((i.number, i.cost, i.seconds)) or len(seen) < 3).solve(
        graph, hf.Values(values))
    assert summary.termination == "stopped" and len(seen) == 3 and seen[0][1] >= seen[-1][1]
    backend = hf.make_backend("irls", progress=lambda i: seen.append(i))
    assert backend.solve(graph, hf.Values(values)).termination == "converged"

    def broken(_):
        raise LookupError("no screen")

    options = backend.options
    options.progress = broken
    backend.options = options
    assert backend.options.progress is broken
    before = hf.Values(values)
    with pytest.raises(LookupError, match="no screen"):
        backend.solve(graph, values)
    assert all(values[key] == before[key] for key in before)


def test_options_pickle_and_refuse():
    options = hf.make_backend("irls", threads=3, time_limit=2.5, trace=True).options
    again = pickle.loads(pickle.dumps(options))
    assert (again.threads, again.time_limit, again.trace, again.max_iterations) == (3, 2.5, True, 0)
    with pytest.raises(hf.BadOption, match="threads"):
        again.threads = 0
    assert again.threads == 3
    options.progress = print
    with pytest.raises(hf.BadOption, match="progress"):
        pickle.dumps(options)
    with pytest.raises(hf.BadOption, match="reweighting"):
        hf.make_backend("nesterov", reweighting="newton")
    with pytest.raises(hf.BadOption, match="reweighting"):
        hf.make_backend("irls", reweighting="new")
    assert hf.make_backend("irls", reweighting="newton", restart=False).name == "irls"


def test_columns():
    graph, values, true, false = ring(false_loops=2, loss=hf.Cauchy(1))
    values.insert("L0", hf.Point2(1, 2))
    summary = hf.make_backend("irls", trace=True).solve(graph, values)
    tables = hf.to_arrays(values)
    assert tables["Pose2"]["x"].shape == (24,) and tables["Point2"]["y"].tolist() == [2]
    assert tables["Pose2"]["step"].tolist() == list(range(24))
    assert tables["Pose2"]["theta"][3] == values["x3"].angle and tables["Pose2"]["key"][3] == "x3"
    report = hf.to_arrays(hf.outlier_report(graph, values))
    assert set(report["number"][report["verdict"] == "outlier"]) >= {id.number for id in false}
    trace = hf.to_arrays(summary)
    assert trace["cost"][-1] <= trace["cost"][0] and len(trace["number"]) > 1
    assert len(hf.to_arrays([])["number"]) == 0
    with pytest.raises(TypeError, match="columns"):
        hf.to_arrays(graph)
    pandas = pytest.importorskip("pandas")
    assert isinstance(hf.to_dataframe(values)["Pose2"], pandas.DataFrame) and len(hf.to_dataframe(summary)) == len(trace["cost"])


def test_every_variable_has_columns():
    values = hf.Values()
    for i, kind in enumerate([hf.Point2, hf.Point3, hf.Pose2, hf.Pose3, hf.Motion2, hf.Motion3, hf.Accel2, hf.Accel3, hf.Turning2,
                              hf.Scalar]):
        values.insert(f"A{i}", kind())
    assert {name: len(table) - 3 for name, table in hf.to_arrays(values).items()} == {
        "Point2": 2, "Point3": 3, "Pose2": 3, "Pose3": 7, "Motion2": 4, "Motion3": 6, "Accel2": 6, "Accel3": 9, "Turning2": 5, "Scalar": 1}


def test_files_there_and_back(tmp_path):
    graph, values, _, _ = ring()
    path = str(tmp_path / "ring.g2o")
    hf.write_problem(path, graph, values)
    again, start = hf.read_problem(path)
    assert again.cost(start) == pytest.approx(graph.cost(values), rel=1e-9)
    with pytest.raises(hf.BadFile, match="format"):
        hf.write_problem(str(tmp_path / "ring.txt"), graph, values)
    assert hf.read_times(path) == {}
    (written,) = hf.write_tum(str(tmp_path), values, {key: 0.5 * key.step for key in values})
    table = np.loadtxt(written)
    assert table.shape == (24, 8) and table[3, 0] == 1.5
    np.testing.assert_allclose(table[3, 1:3], values["x3"].p)


def test_marginalize():
    graph, values, _, _ = ring(n=4)
    hf.make_backend("irls", cost_tolerance=0).solve(graph, values)
    before = hf.Marginals(graph, values).covariance("x2")
    hf.marginalize(graph, values, ["x1"])
    assert "x1" not in values
    np.testing.assert_allclose(hf.Marginals(graph, values).covariance("x2"), before, rtol=1e-6)


def test_what_holds_a_function_that_holds_it_is_collected():
    gone = []

    class Noted:
        def __del__(self):
            gone.append(1)

    for make in (lambda note: hf.make_backend(progress=note), lambda note: hf.Window(on_leaving=note)):
        note, kept = Noted(), []
        holder = make(lambda *_, note=note, kept=kept: None)
        kept.append(holder)
        del note, kept, holder
        gc.collect()
    assert len(gone) == 2


def test_nobody_changes_what_a_solve_reads():
    graph, values, _, _ = ring()
    refused = []

    def meddle(_):
        for change in (lambda: values.insert("x99", hf.Pose2()), lambda: graph.fix("x3"),
                       lambda: graph.add(Prior.from_sigmas(hf.Pose2(), [1, 1, 1]), "x1"),
                       lambda: backend.solve(graph, hf.Values(values)), lambda: hf.marginalize(graph, values, ["x1"])):
            with pytest.raises(hf.BadProblem, match="give each thread its own"):
                change()
            refused.append(1)
        assert graph.cost(hf.Values(values)) > 0

    backend = hf.make_backend("irls", max_iterations=2, progress=lambda i: meddle(i))
    backend.solve(graph, values)
    assert refused
    graph.fix("x3")


def test_a_window_in_use_is_refused_to_other_threads():
    entered, told = threading.Event(), []

    def leaving(key, time):
        entered.set()
        other.join()
        assert window.time(key) == time  # the thread of the step may look

    def meddle():
        entered.wait()
        for use in (lambda: window.values, lambda: window.at("A", 3.0), lambda: window.step(4.0), lambda: window.remove_agent("A")):
            try:
                use()
            except hf.BadProblem as error:
                told.append(str(error))

    window = hf.Window(max_states=1, on_leaving=leaving)
    window.add_agent("A", hf.WhiteAcceleration[hf.Motion2].continuous(1, 1), dt=1)
    window.add_state("A0", 0.0, hf.Motion2())
    window.add(hf.Prior[hf.Motion2].from_sigmas(hf.Motion2(), [1, 1, 1, 1]), ["A0"])
    window.add(hf.Prior[hf.Motion2].from_sigmas(hf.Motion2(), [1, 1, 1, 1]), [window.at("A", 1.0)])
    other = threading.Thread(target=meddle)
    other.start()
    window.step(1.0)
    assert len(told) == 4 and all("give each thread" in one for one in told)
