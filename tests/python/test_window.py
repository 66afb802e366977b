"""Window, Schedule and Trust as C++ has them."""
import math

import numpy as np
import pytest

import holdfast as hf

Motion, White, Range = hf.Motion2, hf.WhiteAcceleration[hf.Motion2], hf.Range[hf.Motion2, hf.Point2]
Fix = hf.Prior[hf.Motion2]
BEACONS = {"L0": (0.0, 0.0), "L1": (40.0, 0.0), "L2": (0.0, 40.0)}


def truth(t):
    return np.array([5 + 2 * t, 10 + 1 * t])


def window_of_a_walker(**options):
    window = hf.Window(lag=2, **options)
    window.add_agent("A", White.continuous(0.1, 0.5), dt=0.1)
    window.add_state("A0", 0.0, Motion([5, 2, 10, 1]))
    window.add(Fix.from_sigmas(Motion([5, 2, 10, 1]), [1, 1, 1, 1]), ["A0"])
    for name, place in BEACONS.items():
        window.add_beacon(name, hf.Point2(*place))
    return window


def walk(window, steps, schedule=None):
    for k in range(1, steps):
        t = round(0.1 * k, 10)
        for name, place in BEACONS.items():
            window.add(Range(math.dist(place, truth(t)), 0.1), [window.at("A", t), name], loss="huber:2")
        step = window.step(t)
    return step


def test_a_walker_is_followed_and_states_leave():
    window = window_of_a_walker(covariances=True, report=True)
    step = walk(window, 60)
    assert step.summary.usable and step.time == pytest.approx(5.9) and step.deadline_kept and step.removed == []
    assert step.left and len(window.states("A")) <= 23 and window.newest("A") == window.states("A")[-1]
    np.testing.assert_allclose(window.values[window.newest("A")].position, truth(5.9), atol=1e-3)
    np.testing.assert_allclose(window.state_at("A", 6.1).position, truth(6.1), atol=1e-2)
    assert window.covariance_at("A", 5.9).shape == (4, 4)
    np.testing.assert_allclose(window.covariance_at("A", 5.9), step.marginals.covariance(window.newest("A")), rtol=1e-6)
    assert {one.verdict for one in step.report} == {"inlier"}
    assert window.time(window.newest("A")) == pytest.approx(5.9) and window.agents == [hf.Agent("A")]


@pytest.mark.parametrize("backend", ["nesterov", "gnc-irls", hf.gnc(hf.make_backend("irls"), mu_factor=1.5)])
def test_on_any_back_end(backend):
    window = window_of_a_walker(backend=backend)
    walk(window, 15)
    np.testing.assert_allclose(window.values[window.newest("A")].position, truth(1.4), atol=0.05)


def test_a_motion_made_by_a_function_is_the_same():
    window, asked = hf.Window(lag=2), []

    def motion(seconds, state):
        asked.append((seconds, type(state)))
        return White.continuous(seconds, 0.5)

    window.add_agent("A", motion, of=White)
    window.add_state("A0", 0.0, Motion([5, 2, 10, 1]))
    window.add(Fix.from_sigmas(Motion([5, 2, 10, 1]), [1, 1, 1, 1]), ["A0"])
    for name, place in BEACONS.items():
        window.add_beacon(name, hf.Point2(*place))
    walk(window, 20)
    other = window_of_a_walker()
    walk(other, 20)
    np.testing.assert_allclose(window.values[window.newest("A")].value, other.values[other.newest("A")].value, atol=1e-9)
    assert asked and asked[0][1] is Motion


def test_a_motion_that_raises_or_returns_another_thing_says_so():
    window = hf.Window()
    window.add_agent("A", lambda seconds, state: 3, of=White)
    window.add_state("A0", 0.0, Motion())
    with pytest.raises(TypeError, match="WhiteAcceleration"):
        window.at("A", 0.1)

    def broken(seconds, state):
        raise KeyError("no map")

    window.add_agent("B", broken, of=White)
    window.add_state("B0", 0.0, Motion())
    with pytest.raises(KeyError, match="no map"):
        window.at("B", 0.1)
    assert len(window.states("A")) == 1 and len(window.states("B")) == 1


def test_odometry_leads_to_states():
    window = hf.Window(max_states=3)
    window.add_state("A0", 0.0, hf.Pose2(0, 0, 0))
    window.add(hf.Prior[hf.Pose2].from_sigmas(hf.Pose2(0, 0, 0), [0.1, 0.1, 0.1]), ["A0"])
    for k in range(1, 10):
        window.add_state(f"A{k}", k, f"A{k - 1}", hf.Between[hf.Pose2].from_sigmas(hf.Pose2(1, 0, 0), [0.1, 0.1, 0.1]))
        window.step(k)
    assert len(window.states("A")) == 3
    np.testing.assert_allclose(window.values["A9"].p, [9, 0], atol=1e-9)


def test_functions_measure_in_a_window():
    def range_to_origin(which, state):
        return (np.hypot(state[:, 0], state[:, 2]) - distances[which])[:, None] / 0.1

    plain, window = window_of_a_walker(), window_of_a_walker()
    distances = np.array([math.hypot(*truth(0.1))])
    key = window.at("A", 0.1)
    window.add_function(range_to_origin, [Motion], [[key]], 1, loss="huber:2")
    plain.add(Range(distances[0], 0.1), [plain.at("A", 0.1), "L0"], loss="huber:2")
    window.step(0.1)
    plain.step(0.1)
    np.testing.assert_allclose(window.values[key].value, plain.values[key].value, atol=1e-4)


def test_a_schedule_tells_what_became_of_each():
    window = window_of_a_walker(report=True)
    schedule = hf.Schedule(window)
    stream = schedule.expect(Range, hf.Agent("A"), hf.Key("L0"), 0.0, 0.1)
    bounded = schedule.expect(Range, hf.Agent("A"), hf.Key("L1"), 0.0, 0.1,
                              missing=lambda last, m: hf.MissingDistance[Motion, hf.Point2](last.distance, last.sigma, 0.3 * math.sqrt(m)))
    for k in range(1, 12):
        t = round(0.1 * k, 10)
        distance = math.dist(BEACONS["L0"], truth(t)) + (30 if k == 7 else 0)
        if k % 4:
            schedule.receive(stream, t, Range(distance, 0.1), loss="truncated_squares:3")
        if k % 3:
            schedule.receive(bounded, t, Range(math.dist(BEACONS["L1"], truth(t)), 0.1))
        schedule.close(t)
        schedule.judge(window.step(t).report)
    assert [schedule.count(stream, why) for why in ("received", "rejected", "dropped")] == [8, 1, 3]
    assert (7, "rejected") in schedule.entries(stream) and (8, "dropped") in schedule.entries(stream)
    missing = [factor for factor in hf.outlier_report(window.graph, window.values) if factor.factor == "MissingDistance"]
    assert len(missing) == 3
    saved = schedule.save()
    schedule.restore(saved)
    assert schedule.save() == saved
    with pytest.raises(TypeError, match="takes no"):
        schedule.receive(stream, 1.2, hf.Range[hf.Pose2, hf.Point2](1, 1))
    with pytest.raises(hf.BadOption, match="lost"):
        schedule.lose(stream, 1.2, "lost")


def test_a_stream_of_another_or_a_dead_schedule_is_refused():
    window = window_of_a_walker()
    one, two = hf.Schedule(window), hf.Schedule(window)
    stream = one.expect(Range, hf.Agent("A"), hf.Key("L0"), 0.0, 0.1)
    del one
    with pytest.raises(hf.BadKey):
        two.receive(stream, 0.1, Range(1, 1))
    with pytest.raises(hf.BadKey):
        two.count(stream, "received")


def test_a_schedule_keeps_its_window():
    schedule = hf.Schedule(window_of_a_walker())
    stream = schedule.expect(Range, hf.Agent("A"), hf.Key("L0"), 0.0, 0.1)
    schedule.receive(stream, 0.1, Range(10, 1))
    schedule.close(0.5)
    assert schedule.count(stream, "received") == 1


def test_an_agent_finds_its_way_back():
    window = hf.Window(lag=3)
    window.add_agent("A", White.continuous(0.1, 0.5), dt=0.1)
    window.keep_lock("A", Motion, lambda seen: Fix.from_sigmas(seen, [1000, 20, 1000, 20]), memory=30)
    for name, place in BEACONS.items():
        window.add_beacon(name, hf.Point2(*place))
    lost, reacquired, rng = [], [], np.random.default_rng(3)
    for k in range(120):
        t = round(0.1 * k, 10)
        for name, place in BEACONS.items():
            jump = np.array([120.0, -60.0]) if k >= 60 else np.zeros(2)
            distance = math.dist(place, truth(t) + jump) + 0.1 * rng.standard_normal()
            window.add(Range(distance, 0.1), [window.at("A", t), name], loss="truncated_squares:3.5")
        step = window.step(t)
        lost += step.lost
        reacquired += step.reacquired
    assert lost and reacquired and set(reacquired) == {hf.Agent("A")}
    np.testing.assert_allclose(window.values[window.newest("A")].position, truth(11.9) + [120, -60], atol=0.5)


def test_a_window_comes_back_bit_by_bit(tmp_path):
    path, gone = str(tmp_path / "window"), []
    window = window_of_a_walker(on_leaving=lambda key, time: gone.append((str(key), time)))
    walk(window, 30)
    window.save(path, b"note")
    again = window_of_a_walker()
    assert again.restore(path) == b"note" and gone
    t = 3.0
    for one in (window, again):
        one.add(Range(math.dist(BEACONS["L0"], truth(t)), 0.1), [one.at("A", t), "L0"])
        one.step(t)
    assert window.values[window.newest("A")] == again.values[again.newest("A")]
    (tmp_path / "window").write_bytes(b"torn")
    with pytest.raises(hf.BadFile):
        again.restore(path)


def test_errors_of_a_window_name_the_culprit():
    window = window_of_a_walker(max_gap=10)
    other = hf.Graph()
    for wrong, error, said in [
        (lambda: hf.Window(lag=-1), hf.BadOption, "lag"),
        (lambda: hf.Window(leaving="stay"), hf.BadOption, "leaving"),
        (lambda: hf.Window(backend="magic"), hf.BadOption, "magic"),
        (lambda: hf.Window(on_leaving=3), TypeError, "function"),
        (lambda: window.at("B", 1.0), hf.BadKey, "B"),
        (lambda: window.at("A", math.nan), hf.BadTime, "nan"),
        (lambda: window.at("A", 100.0), hf.BadTime, "100"),
        (lambda: window.at("A", 0.123), hf.BadTime, "0.123"),
        (lambda: window.at(3, 1.0), TypeError, "agent"),
        (lambda: window.add_agent("A", White.continuous(0.1, 1), dt=0.1), hf.BadKey, "A"),
        (lambda: window.add_agent("C", White.continuous(0.1, 1), dt=-1), hf.BadNumber, "dt"),
        (lambda: window.add_agent("C", 3), TypeError, "motion factor"),
        (lambda: window.add_agent("C", 3, dt=0.1), TypeError, "steps"),
        (lambda: window.add_state("A5", 0.5, 3.0), TypeError, "add_state"),
        (lambda: window.add_state("C1", 1.0, "C0", 3), TypeError, "leads to"),
        (lambda: window.add(Range(1, 1), ["A9", "L0"]), hf.BadKey, "A9"),
        (lambda: window.add(hf.Range[hf.Pose2, hf.Point2](1, 1), ["A0", "L0"]), hf.BadType, "Motion2"),
        (lambda: window.add(Range(math.nan, 1), ["A0", "L0"]), hf.BadNumber, "distance"),
        (lambda: window.remove([other.add(Range(1, 1), ["A0", "L0"]) for _ in range(9)][-1]), hf.BadKey, "8"),
        (lambda: window.state_at("A", -5.0), hf.BadTime, "-5"),
        (lambda: window.newest("Q"), hf.BadKey, "Q"),
        (lambda: window.keep_lock("A", Motion, lambda seen: None), hf.BadOption, "states already"),
        (lambda: window.save("/nowhere/at/all"), hf.BadFile, "nowhere"),
    ]:
        with pytest.raises(error, match=said):
            wrong()
    assert len(window.states("A")) == 1


def test_trust_counts_what_fits():
    trust = hf.Trust(recent=4, gate=3)
    assert trust.fits(8.9, 1) and not trust.fits(9.1, 1)
    changes = [trust.judge(7, i, i < 4) for i in range(8)]
    assert changes.count("lost") == 1 and not trust.is_believed(7) and trust.disbelieved == [7]
    assert [trust.judge(7, 10 + i, True) for i in range(4)].count("regained") == 1
    assert trust.latest(7) == [(10 + i, True) for i in range(4)]
    with pytest.raises(hf.BadOption):
        hf.Trust(recent=0)
