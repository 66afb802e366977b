"""Every factor and loss by its fields: made, compared, pickled, and refused where a number is none."""
import copy
import math
import pickle

import numpy as np
import pytest

import holdfast as hf

VARIABLES = {"Point2": hf.Point2, "Point3": hf.Point3, "Pose2": hf.Pose2, "Pose3": hf.Pose3, "Motion2": hf.Motion2, "Motion3": hf.Motion3,
             "Accel2": hf.Accel2, "Accel3": hf.Accel3, "Turning2": hf.Turning2, "Scalar": hf.Scalar}
FACTORS = sorted((name for name in dir(hf._core) if hasattr(getattr(hf._core, name), "_add")))


def example(type_):
    """A value of a field, by its type as a file names it."""
    if type_ == "double":
        return 1.0
    if type_ in ("int32", "enum int32"):
        return 1
    name, size = type_.rstrip("]").split("[")
    if name in VARIABLES:
        return VARIABLES[name]()
    rows, columns = (int(n) for n in size.split("x"))
    return np.eye(rows, columns) if columns > 1 else np.eye(1, rows)[0]


def fields_of(name):
    """A lever is 0: a point has no body frame."""
    fields = (one.split(" ", 1) for one in getattr(hf._core, name).fields.split(", "))
    return {field: example(type_) * (0 if field.startswith("lever") else 1) if "[" in type_ and "x" in type_ else example(type_)
            for field, type_ in fields}


def made(name):
    return getattr(hf._core, name)(**fields_of(name))


def on_its_variables(name):
    """A graph of this factor alone, and values it may be asked at."""
    graph, values = hf.Graph(), hf.Values()
    keys = []
    names = [VARIABLES[part] for part in name.split("_")[1:]]
    for i, variable in enumerate(names):
        keys.append(f"A{i}")
        values.insert(keys[-1], variable().retract(np.linspace(0.1, 0.7, variable.dim) + i))
    return graph, values, keys


@pytest.mark.parametrize("name", FACTORS)
def test_a_factor_has_fields_pickles_and_is_solved_with(name):
    one = made(name)
    for again in (pickle.loads(pickle.dumps(one)), copy.deepcopy(one)):
        assert again == one and type(again) is type(one)
    assert one != 3
    graph, values, keys = on_its_variables(name)
    id = graph.add(one, keys, loss=hf.Cauchy(2))
    cost = graph.cost(values)
    assert math.isfinite(cost) and cost >= 0 and np.isfinite(graph.residual(id, values)).all()
    again = pickle.loads(pickle.dumps(graph))
    assert again.cost(pickle.loads(pickle.dumps(values))) == cost and id in again


@pytest.mark.parametrize("name", FACTORS)
def test_a_field_that_is_no_number_is_refused(name):
    factor = getattr(hf._core, name)
    fields = fields_of(name)
    for field, value in fields.items():
        with pytest.raises(TypeError):
            factor(**{**fields, field: "far"})
        with pytest.raises(TypeError):
            factor(**{**fields, field: None})
        if isinstance(value, np.ndarray):
            with pytest.raises(TypeError):
                factor(**{**fields, field: np.ones(17)})


def test_a_graph_comes_back_bit_by_bit_with_its_ids():
    graph, values = hf.Graph(), hf.Values()
    for k in range(20):
        values.insert(f"A{k}", hf.Point2(1 / 3 * k, math.pi / (k + 1)))
    ids = [graph.add(hf.Range[hf.Point2, hf.Point2](1 / 7, 0.1), [f"A{k}", f"A{k + 1}"], loss=hf.Welsch(1 + k / 9)) for k in range(19)]
    graph.remove(ids[3])
    graph.fix("A0")
    again, there = pickle.loads(pickle.dumps((graph, values)))
    assert again.cost(there) == graph.cost(values) and again.is_fixed("A0") and ids[3] not in again and ids[4] in again
    assert {ids[4]: 1}[pickle.loads(pickle.dumps(ids[4]))] == 1
    assert hf.make_backend().solve(again, there).cost == hf.make_backend().solve(graph, values).cost
    assert there["A7"] == values["A7"]


def test_what_cannot_be_pickled_says_so():
    graph = hf.Graph()
    graph.add_function(lambda which, a: a, [hf.Point2], [["A0"]], 2, name="Mine")
    with pytest.raises(hf.BadFile, match="Mine|Function"):
        pickle.dumps(graph)


@pytest.mark.parametrize("state", [b"", b"\0" * 7, b"\xff" * 64, b"holdfast"])
def test_a_torn_pickle_is_refused(state):
    for kind in (hf.Graph, hf.Values):
        with pytest.raises(hf.Error):
            kind.__new__(kind).__setstate__(state)


def test_bytes_of_a_graph_that_flip_never_crash():
    graph, values = hf.Graph(), hf.Values()
    values.insert("A0", hf.Point2(1, 2))
    graph.add(hf.Prior[hf.Point2].from_sigmas(hf.Point2(0, 0), [1, 1]), "A0", loss="huber:2")
    whole = graph.__getstate__()
    for i in range(len(whole)):
        torn = whole[:i] + bytes([whole[i] ^ 0x41]) + whole[i + 1:]
        try:
            again = hf.Graph.__new__(hf.Graph)
            again.__setstate__(torn)
            again.cost(values)
        except (hf.Error, ValueError, MemoryError):
            pass


@pytest.mark.parametrize("loss, text", [(hf.Huber(2), "huber:2"), (hf.per_component(hf.Cauchy(1)), "cauchy:1:component"),
                                        (hf.one_sided(hf.Tukey(4)), "tukey:4:one_sided"), (hf.StudentT(3), "student_t:3"),
                                        (hf.MaxMixture(10), "max_mixture:10"), (hf.DynamicCovarianceScaling(2), "dcs:2"),
                                        (hf.SwitchableConstraint(2), "geman_mcclure:2"), (hf.Absolute(0.1), "absolute:0.1"),
                                        (hf.Squared(), "squared"),
                                        (hf.PseudoHuber(2), "pseudo_huber:2"), (hf.GemanMcClure(2), "geman_mcclure:2"),
                                        (hf.Welsch(3), "welsch:3"), (hf.TruncatedSquares(3), "truncated_squares:3")])
def test_losses_have_names_and_pickle(loss, text):
    assert str(loss) == text and hf.Loss(text) == loss and pickle.loads(pickle.dumps(loss)) == loss and loss != text + "?"
    value, slope, _ = loss.rho(1.5)
    step = 1e-6
    assert slope == pytest.approx((loss.rho(1.5 + step)[0] - loss.rho(1.5 - step)[0]) / (2 * step), rel=1e-5)
    assert value >= 0 and loss.rho(0)[0] == 0
    third = hf.Huber(1 / 3)
    assert pickle.loads(pickle.dumps(third)) == third


def test_losses_refuse_what_is_no_threshold():
    for bad in (lambda: hf.Huber(2).rho(-1), lambda: hf.Huber(2).rho(math.nan), lambda: hf.Huber(-1).rho(1),
                lambda: hf.Huber(2).rho(1, 0)):
        with pytest.raises(hf.BadNumber):
            bad()
    graph = hf.Graph()
    with pytest.raises(hf.Error):
        graph.add(hf.Range[hf.Point2, hf.Point2](1, 1), ["A0", "A1"], loss=hf.Cauchy(math.nan))
    assert len(graph) == 0


def test_motion_factors_are_made_as_in_cpp():
    white = hf.WhiteAcceleration[hf.Motion2]
    one = white.continuous(0.1, 0.5)
    assert one.merged(3) == white.continuous(3 * 0.1, 0.5)
    # Q of one axis: q [T³/3 T²/2; T²/2 T]
    covariance = np.linalg.inv(one.sqrt_information.T @ one.sqrt_information)
    np.testing.assert_allclose(covariance[:2, :2], 0.5 * np.array([[0.1**3 / 3, 0.1**2 / 2], [0.1**2 / 2, 0.1]]), rtol=1e-9)
    assert white.exact(0.1, 2, np.eye(4)).merged(2) == white.exact(0.1, 4, np.eye(4))
    assert hf.WhiteJerk[hf.Accel2].continuous(0.1, 1).merged(2).duration == pytest.approx(0.2)
    edge = hf.HuberMeasurementEdge[hf.Point2, hf.Point2].of_position([1, 2], np.eye(2))
    graph, values = hf.Graph(), hf.Values()
    values.insert("A0", hf.Point2(4, 6))
    values.insert("B0", hf.Point2(3, 3))
    np.testing.assert_allclose(graph.residual(graph.add(edge, ["A0", "B0"]), values), [0, -1])
    with pytest.raises(hf.BadNumber, match="q"):
        white.continuous(0.1, -1)
