"""Robust factors for multi-agent state estimation, and back-ends that any of them runs on.

    import holdfast as hf
    graph, values = hf.Graph(), hf.Values()
    values.insert("A0", hf.Pose2(0, 0, 0))
    values.insert("L0", hf.Point2(1, 1))
    graph.add(hf.Range[hf.Pose2, hf.Point2](distance=5, sigma=0.1), ["A0", "L0"], loss="huber:2")
    summary = hf.make_backend("irls").solve(graph, values)

A key is a Key, or its text: "A11", "r1234:7".
"""
from . import _core
from ._core import *  # noqa: F401,F403
from ._core import Graph, Incremental, Key, Loss, Values
from ._plot import plot, positions  # noqa: F401
from ._tables import to_arrays, to_dataframe  # noqa: F401
from ._window import Schedule  # noqa: F401
from ._window import install as _install_window


class Template:
    """A factor by the types of its variables: Range[Pose2, Point2], Prior[Pose2]."""

    def __init__(self, name):
        self.__name__ = name
        self._by_types = {}

    def __getitem__(self, types):
        names = tuple(t.__name__ for t in (types if isinstance(types, tuple) else (types,)))
        if names not in self._by_types:
            known = ", ".join("[" + ", ".join(k) + "]" for k in sorted(self._by_types))
            raise TypeError(f"there is no {self.__name__}[{', '.join(names)}]; there are: {known}")
        return self._by_types[names]

    def __repr__(self):
        return self.__name__


def _enter_factors():
    for full in dir(_core):
        name, *types = full.split("_")
        if types and hasattr(getattr(_core, full), "_add"):
            globals().setdefault(name, Template(name))._by_types[_types_of(name, types)] = getattr(_core, full)


def _types_of(name, types):
    of_one_type = name in ("Between", "ConstantTurn", "CoordinatedTurn") or name.startswith("White")
    return tuple(types[:1]) if of_one_type else tuple(types)


def _key(key):
    """Of a Key, its text, or its bits. Converted here, so that what is wrong with a text is said."""
    if isinstance(key, Key):
        return key
    return Key(key) if isinstance(key, str) else Key.from_bits(int(key))


def _loss(loss):
    return Loss(loss) if isinstance(loss, str) else loss


def _add(self, factor, keys, loss=None, weight=None):
    """Adds a factor on as many keys as it has variables; without loss and weight with its own. Returns its FactorId."""
    if not hasattr(factor, "_add"):
        raise TypeError(f"{factor!r} is no factor")
    return factor._add(self, [_key(k) for k in ([keys] if isinstance(keys, (str, Key)) else keys)], _loss(loss), weight)


def _is_column(field):
    return hasattr(field, "__len__") and not isinstance(field, str) and getattr(field, "ndim", 1) > 0


def _add_many(self, factor_type, keys, *fields, loss=None, weight=None):
    """One factor a row of keys (n × variables: Keys, texts, or Key.bits); each field an array of n, or one number for all."""
    n = len(keys)
    loss = _loss(loss)
    columns = [column if _is_column(column) else [column] * n for column in fields]
    for column in columns:
        if len(column) != n:
            raise ValueError(f"{n} rows of keys, and a field of {len(column)}")
    rows = [[_key(k) for k in row] for row in keys]
    factors = [factor_type(*row) for row in zip(*columns)]
    ids = []
    try:
        for factor, row in zip(factors, rows):
            ids.append(factor._add(self, row, loss, weight))
    except Exception:
        for one in ids:  # all or none
            self.remove(one)
        raise
    return ids


_add_function_of_core = Graph.add_function


def _add_function(self, function, types, keys, residual_dim, loss=None, **more):
    rows = [[_key(k) for k in row] for row in keys]
    return _add_function_of_core(self, function, types, rows, residual_dim, Loss("squared") if loss is None else _loss(loss), **more)


_add_function.__doc__ = _add_function_of_core.__doc__


def _insert(self, key, value):
    """A new variable, with where it begins."""
    values = Values()
    values.insert(_key(key), value)
    self.insert_from(values, _key(key))


def _add_to_incremental(self, factor, keys, loss=None, weight=None):
    """A new factor; loss and weight as in Graph.add. Returns its FactorId."""
    graph = Graph()
    return self.add_from(graph, _add(graph, factor, keys, loss, weight))


def _at(self, key):
    """The estimate of one variable."""
    return self.values()[_key(key)]


_enter_factors()
Graph.add = _add
Graph.add_many = _add_many
Graph.add_function = _add_function
Incremental.insert = _insert
Incremental.add = _add_to_incremental
Incremental.at = _at


def _prior_of(state):
    """A prior on this type of variable: which one it is."""
    prior = globals()["Prior"][state]
    return prior.from_sigmas(state(), [1.0] * state.dim)


Schedule._or_squared = staticmethod(_install_window(_key, _loss, _prior_of))
