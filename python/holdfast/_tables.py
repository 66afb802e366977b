"""Answers as columns: dicts of NumPy arrays, and with pandas as data frames."""
from . import _core

_COLUMNS = {"Point2": ["x", "y"], "Point3": ["x", "y", "z"], "Pose2": ["x", "y", "theta"],
            "Pose3": ["x", "y", "z", "qx", "qy", "qz", "qw"], "Motion2": ["x", "vx", "y", "vy"],
            "Motion3": ["x", "vx", "y", "vy", "z", "vz"], "Accel2": ["x", "vx", "ax", "y", "vy", "ay"],
            "Accel3": ["x", "vx", "ax", "y", "vy", "ay", "z", "vz", "az"], "Turning2": ["x", "vx", "y", "vy", "omega"], "Scalar": ["value"]}


def _row(variable):
    if isinstance(variable, _core.Pose2):
        return [*variable.p, variable.angle]
    if isinstance(variable, _core.Pose3):
        return [*variable.p, *variable.q]
    if isinstance(variable, _core.Scalar):
        return [variable.value]
    return variable.value


def _values_to_arrays(values):
    import numpy as np

    rows = {}
    for key in values:
        variable = values[key]
        rows.setdefault(type(variable).__name__, []).append((key, _row(variable)))
    tables = {}
    for name, of_type in rows.items():
        numbers = np.array([row for _, row in of_type], float)
        tables[name] = {"key": np.array([str(key) for key, _ in of_type]), "agent": np.array([str(key.agent) for key, _ in of_type]),
                        "step": np.array([key.step for key, _ in of_type], np.int64)}
        tables[name].update({column: numbers[:, i] for i, column in enumerate(_COLUMNS[name])})
    return tables


def _report_to_arrays(report):
    import numpy as np

    return {"number": np.array([one.id.number for one in report], np.int64), "factor": np.array([one.factor for one in report], str),
            "keys": np.array([" ".join(map(str, one.keys)) for one in report], str),
            "sigmas": np.array([float(np.linalg.norm(one.whitened)) for one in report], float),
            "weight": np.array([one.weight for one in report], float), "verdict": np.array([one.verdict for one in report], str)}


def _trace_to_arrays(summary):
    import numpy as np

    columns = np.array(summary.trace, float).reshape(-1, 4)
    return {"number": columns[:, 0].astype(np.int64), "cost": columns[:, 1], "gradient_norm": columns[:, 2], "seconds": columns[:, 3]}


def to_arrays(what):
    """Columns as NumPy arrays: of Values {type: {key, agent, step, coordinates …}}, of an outlier report one row a factor, of a Summary
    its trace."""
    if isinstance(what, _core.Values):
        return _values_to_arrays(what)
    if isinstance(what, _core.Summary):
        return _trace_to_arrays(what)
    if isinstance(what, (list, tuple)) and all(isinstance(one, _core.MeasurementReport) for one in what):
        return _report_to_arrays(what)
    raise TypeError(f"there are columns of Values, of a Summary and of an outlier report, not of {what!r}")


def to_dataframe(what):
    """to_arrays() as pandas data frames: of Values {type: frame}, else one frame. Needs pandas."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("holdfast.to_dataframe needs pandas: pip install pandas; to_arrays() does without") from error
    arrays = to_arrays(what)
    if isinstance(what, _core.Values):
        return {name: pandas.DataFrame(columns) for name, columns in arrays.items()}
    return pandas.DataFrame(arrays)
