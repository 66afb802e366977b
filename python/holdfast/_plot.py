"""Answers as pictures."""
from . import _core


def positions(values):
    """{agent: (n × 2 or n × 3 array, keys)}: the positions of all variables that have one, each agent's in the order of its steps."""
    import numpy as np

    tracks = {}
    for key in values:
        variable = values[key]
        position = getattr(variable, "position", None)
        if position is None:
            continue
        tracks.setdefault(str(key.agent), ([], []))
        tracks[str(key.agent)][0].append(np.asarray(position, float))
        tracks[str(key.agent)][1].append(key)
    return {agent: (np.array(points), keys) for agent, (points, keys) in tracks.items()}


def plot(values, path=None):
    """The trajectories and landmarks of the values as a plotly figure; with `path`, written there as a page. Needs plotly."""
    try:
        import plotly.graph_objects as go
    except ImportError as error:
        raise ImportError("holdfast.plot needs plotly: pip install plotly") from error
    figure = go.Figure()
    for agent, (points, keys) in positions(values).items():
        is_track = not isinstance(values[keys[0]], (_core.Point2, _core.Point3))
        style = {"name": agent, "mode": "lines" if is_track else "markers", "text": [str(key) for key in keys], "x": points[:, 0],
                 "y": points[:, 1]}
        if points.shape[1] == 3:
            figure.add_trace(go.Scatter3d(z=points[:, 2], marker={"size": 3}, **style))
        else:
            figure.add_trace(go.Scatter(**style))
    figure.update_layout(xaxis={"title": "x [m]"}, yaxis={"title": "y [m]", "scaleanchor": "x"})
    if path is not None:
        figure.write_html(path)
    return figure
