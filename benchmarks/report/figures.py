"""Tables and figures of the page, as HTML. Each figure is plotly's; nothing is fetched."""
import html
import math

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a6d3b", "#777777"]  # Okabe and Ito: for every eye
DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"]
CORNERS = 36  # of an ellipse


def number(value, form=".4g"):
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    return "∞" if math.isinf(value) else format(value, form)


def table(titles, rows, caption):
    cells = "".join(f"<th scope=col>{html.escape(title)}</th>" for title in titles)
    body = "".join("<tr>" + "".join(f"<th scope=row>{html.escape(str(cell))}</th>" if i == 0 else f"<td>{html.escape(str(cell))}</td>"
                                    for i, cell in enumerate(row)) + "</tr>" for row in rows)
    name = html.escape(caption, quote=True)
    return (f"<p>{html.escape(caption)}. <button class=csv aria-label='CSV: {name}'>CSV</button></p>"
            f"<div class=wide role=region tabindex=0 aria-label='{name}'>"
            f"<table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table></div>")


def folded(title, parts):
    return f"<details><summary>{html.escape(title)}</summary>{''.join(parts)}</details>" if parts else ""


def figure(traces, title, x, y, x_log=True, y_log=False):
    """traces: [(name, (xs, ys), mode, shape of the line)]"""
    import plotly.graph_objects as go
    drawn = go.Figure()
    for i, (name, (xs, ys), mode, shape) in enumerate(traces):
        line = {"color": COLOURS[i % len(COLOURS)], "dash": DASHES[i % len(DASHES)], "shape": shape}
        drawn.add_trace(go.Scatter(x=xs, y=ys, name=name, mode=mode, line=line))
    return shown(drawn, title, x, y, x_log, y_log)


def shown(drawn, title, x, y, x_log=False, y_log=False):
    """The figure as data; the page's script draws it when it comes into view."""
    rows = math.ceil(len(drawn.data) / 2)  # of the legend on a phone
    drawn.update_layout(template="none", paper_bgcolor="rgba(0,0,0,0)", plot_bgcolor="rgba(0,0,0,0)", font={"size": 14}, showlegend=True,
                        legend={"orientation": "h", "yref": "container", "y": 0, "yanchor": "bottom", "x": 0}, height=400 + 24 * rows,
                        margin={"l": 70, "r": 10, "t": 10, "b": 60 + 24 * rows})
    grid = {"gridcolor": "rgba(128,128,128,0.3)", "zeroline": False, "automargin": False, "exponentformat": "power"}
    drawn.update_xaxes(title=x, type="log" if x_log else "linear", **grid)
    drawn.update_yaxes(title=y, type="log" if y_log else "linear", **grid)
    data = drawn.to_json().replace("</", "<\\/")
    return (f"<figure><figcaption>{html.escape(title)}</figcaption><div class=plot style='height:{400 + 24 * rows}px'></div>"
            f"<script type='application/json'>{data}</script></figure>")


def ellipse(x, y, xx, xy, yy, sigmas=3):
    """Corners of the ellipse of so many sigmas of a covariance [m²] round a place."""
    half, apart = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    a, b = (sigmas * math.sqrt(max(half + sign * apart, 0)) for sign in (1, -1))
    turn = math.atan2(2 * xy, xx - yy) / 2
    corners = []
    for i in range(CORNERS + 1):
        along, across = a * math.cos(2 * math.pi * i / CORNERS), b * math.sin(2 * math.pi * i / CORNERS)
        corners.append((x + along * math.cos(turn) - across * math.sin(turn), y + along * math.sin(turn) + across * math.cos(turn)))
    return corners


def broken(paths):
    """(xs, ys) of several paths in one trace, a gap between them; to the millimetre."""
    xs = [round(p[0], 3) if p else None for path in paths for p in (*path, None)]
    ys = [round(p[1], 3) if p else None for path in paths for p in (*path, None)]
    return xs, ys


def from_above(drawing, title):
    """Ways and landmarks, true and estimated, with ellipses of 3σ and what the answer rejects."""
    import plotly.graph_objects as go
    drawn = go.Figure()
    if drawing["rejected"]:
        xs, ys = broken([[line[:2], line[2:]] for line in drawing["rejected"]])
        drawn.add_trace(go.Scatter(x=xs, y=ys, name=f"outliers ({len(drawing['rejected'])})", mode="lines",
                                   line={"color": COLOURS[1], "dash": "dot", "width": 1}))
    if drawing.get("ellipses"):
        xs, ys = broken([ellipse(*one) for one in drawing["ellipses"]])
        drawn.add_trace(go.Scatter(x=xs, y=ys, name="3σ", mode="lines", fill="toself", hoverinfo="skip",
                                   line={"color": "#808080", "width": 1}, fillcolor="rgba(128,128,128,0.15)"))
    for i, track in enumerate(drawing["tracks"]):
        mode = "lines" if track["is_way"] else "markers"
        colour = COLOURS[(0, 2, 3, 4, 5, 6)[i % 6]]
        if track["truth"]:
            drawn.add_trace(go.Scatter(x=[p[0] for p in track["truth"]], y=[p[1] for p in track["truth"]], name=f"{track['name']}, true",
                                       mode=mode, line={"color": "#808080", "dash": "dot"}, marker={"color": "#808080", "symbol": "x"}))
        drawn.add_trace(go.Scatter(x=[p[0] for p in track["estimate"]], y=[p[1] for p in track["estimate"]], name=track["name"], mode=mode,
                                   line={"color": colour}, marker={"color": colour}))
    drawn.update_yaxes(scaleanchor="x")
    return shown(drawn, title, "x [m]", "y [m]")


def errors_over_time(line):
    import plotly.graph_objects as go
    times, errors, bands = zip(*line["errors"])
    drawn = go.Figure()
    around = bands + tuple(-band for band in bands[::-1])
    drawn.add_trace(go.Scatter(x=times + times[::-1], y=around, name="3σ of x", fill="toself", mode="lines",
                               line={"color": COLOURS[5], "width": 1}, fillcolor="rgba(86,180,233,0.3)"))
    drawn.add_trace(go.Scatter(x=times, y=errors, name="error", mode="lines", line={"color": COLOURS[1]}))
    within = sum(abs(error) <= band for error, band in zip(errors, bands))
    return shown(drawn, f"{line['window']}: {within} of {len(errors)} within 3σ", "seconds", "error of x [m]")


def steps_over_time(line):
    """Whether a window slows down the longer it runs."""
    seconds, medians, worst = zip(*line["over_time"])
    return figure([("median", (seconds, medians), "lines", "linear"), ("worst", (seconds, worst), "lines", "linear")],
                  f"{line['window']}: a step over time, {len(seconds)} slices", "seconds since the start", "µs", x_log=False, y_log=True)
