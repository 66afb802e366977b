#!/usr/bin/env python3
"""One self-contained page of what `holdfast bench` measured, drawn from its lines of JSON alone.

    scripts/report [bench-out [bench-out/index.html]]

On top who wins by what factor at equal cost, then profiles, growth, a table for each suite with its answers from above (of the directory
drawings/), cost against time and errors with their 3σ bands, and the papers. Nothing is fetched from any
host: plotly's script is in the page. Of each file only the lines of its newest commit count. Needs plotly (scripts/report installs it into
build/venv)."""
import datetime
import html
import json
import math
import os
import statistics
import sys

SAME_COST = 1e-6  # relative: two costs that are one (common/report.hpp, kSameCost)
SHIFT = 0.01  # [s] of the shifted geometric mean: below it, differences hardly count
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a6d3b", "#777777"]  # Okabe and Ito: for every eye
DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"]


def read(folder):
    """{suite: lines of its newest commit}, and the places of lines that are no JSON object."""
    suites, torn = {}, []
    for name in sorted(os.listdir(folder)):
        if not name.endswith(".jsonl"):
            continue
        lines = []
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            for number, text in enumerate(file, 1):
                try:
                    line = json.loads(text)
                except json.JSONDecodeError:
                    line = None
                if isinstance(line, dict):
                    lines.append(line)
                else:
                    torn.append(f"{name}:{number}")
        if lines:
            suites[name[:-len(".jsonl")]] = [line for line in lines if line.get("commit") == lines[-1].get("commit")]
    return suites, torn


def stem(file):
    return os.path.splitext(os.path.basename(file))[0]


def problems(suites):
    """{(suite, problem, loss, start): {back-end: its last run}} of all suites that solve problems, one thread."""
    found = {}
    for suite, lines in suites.items():
        for line in lines:
            if "file" in line and "cost" in line and "backend" in line and line.get("threads", 1) == 1:
                key = (suite, stem(line["file"]), line.get("loss", ""), line.get("start", ""))
                found.setdefault(key, {})[line["backend"]] = line
    return found


def ended(run):
    return run["termination"] != "failed" and run["cost"] is not None


def excess(runs):
    """{back-end: how far its cost lies above the best of the problem, relative}; infinite for a failure."""
    costs = [run["cost"] for run in runs.values() if ended(run)]
    best = min(costs) if costs else math.nan
    return {name: (run["cost"] - best) / max(abs(best), 1e-300) if ended(run) else math.inf for name, run in runs.items()}


def seconds_at_equal_cost(runs):
    """{back-end: seconds}; infinite where it failed or ended above the best cost of the problem."""
    above = excess(runs)
    return {name: run["seconds"] if above[name] <= SAME_COST else math.inf for name, run in runs.items()}


def shifted_geometric_mean(seconds, limit):
    """exp mean log(s + shift) - shift; what did not arrive counts as the limit of time."""
    return math.exp(statistics.fmean(math.log(min(s, limit) + SHIFT) for s in seconds)) - SHIFT


def ranking(found):
    """Over the problems that all of these back-ends ran: [(back-end, mean seconds, arrived, problems, wins)], the best first."""
    names = {name for runs in found.values() for name in runs}
    most = max((sum(name in runs for runs in found.values()) for name in names), default=0)
    names = {name for name in names if 2 * sum(name in runs for runs in found.values()) >= most}
    shared = [runs for runs in found.values() if names <= set(runs)]
    rows = []
    for name in names:
        times = [seconds_at_equal_cost(runs) for runs in shared]
        limit = max((run.get("time_limit") or 60.0 for runs in shared for run in runs.values()), default=60.0)
        own = [time[name] for time in times]
        wins = sum(math.isfinite(time[name]) and time[name] <= min(time[other] for other in names) for time in times)
        rows.append((name, shifted_geometric_mean(own, limit) if own else math.nan, sum(map(math.isfinite, own)), len(own), wins))
    return sorted(rows, key=lambda row: row[1])


def steps_of_profile(ratios, count):
    """The points (ratio, part of the problems within it) of Dolan and More's profile."""
    finite = sorted(ratio for ratio in ratios if math.isfinite(ratio))
    return finite, [(i + 1) / count for i in range(len(finite))]


def profile(found, measure):
    """{back-end: points}: measure(runs) gives {back-end: number >= 0}, the ratio is to the best of each problem."""
    names = sorted({name for runs in found.values() for name in runs})
    points = {}
    for name in names:
        of_name = [measure(runs) for runs in found.values() if name in runs]
        ratios = []
        for numbers in of_name:
            best = min(numbers.values())
            ratios.append(numbers[name] / best if math.isfinite(numbers[name]) and best > 0 else math.inf)
        points[name] = steps_of_profile(ratios, len(of_name))
    return points


def number(value, form=".4g"):
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    return "∞" if math.isinf(value) else format(value, form)


def table(titles, rows, caption):
    cells = "".join(f"<th scope=col>{html.escape(title)}</th>" for title in titles)
    body = "".join("<tr>" + "".join(f"<th scope=row>{html.escape(str(cell))}</th>" if i == 0 else f"<td>{html.escape(str(cell))}</td>"
                                    for i, cell in enumerate(row)) + "</tr>" for row in rows)
    return (f"<p>{html.escape(caption)}.</p><div class=wide role=region tabindex=0 aria-label='{html.escape(caption, quote=True)}'>"
            f"<table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table></div>")


def figure(traces, title, x, y, x_log=True, y_log=False):
    import plotly.graph_objects as go
    drawn = go.Figure()
    for i, (name, (xs, ys), mode, shape) in enumerate(traces):
        line = {"color": COLOURS[i % len(COLOURS)], "dash": DASHES[i % len(DASHES)], "shape": shape}
        drawn.add_trace(go.Scatter(x=xs, y=ys, name=name, mode=mode, line=line))
    return shown(drawn, title, x, y, x_log, y_log)


def shown(drawn, title, x, y, x_log=False, y_log=False):
    drawn.update_layout(title=title, paper_bgcolor="rgba(0,0,0,0)", plot_bgcolor="rgba(0,0,0,0)", font={"color": "#808080", "size": 14},
                        legend={"orientation": "h", "y": -0.25}, margin={"l": 60, "r": 10, "t": 50, "b": 60}, height=420)
    grid = {"gridcolor": "rgba(128,128,128,0.3)", "zeroline": False}
    drawn.update_xaxes(title=x, type="log" if x_log else "linear", **grid)
    drawn.update_yaxes(title=y, type="log" if y_log else "linear", **grid)
    picture = drawn.to_html(full_html=False, include_plotlyjs=False, config={"responsive": True, "displaylogo": False})
    return f"<figure>{picture}</figure>"


def who_wins(found):
    rows = ranking(found)
    if not rows:
        return ""
    best = rows[0]
    lead = f"<p class=lead><strong>{html.escape(best[0])}</strong> is the fastest at equal cost over {best[3]} problems"
    if len(rows) > 1:
        lead += f": {rows[1][1] / best[1]:.1f} times faster than {html.escape(rows[1][0])} (shifted geometric mean)"
    shown = [(name, number(mean), f"{mean / best[1]:.2f}", f"{arrived} of {count}", wins) for name, mean, arrived, count, wins in rows]
    return "<h2>Who wins</h2>" + lead + ".</p>" + table(
        ["back-end", "mean [s]", "over the best", "reached the best cost", "fastest"], shown,
        f"Shifted geometric mean (shift {SHIFT} s) of the whole solve() call, over the problems that all of these ran; who failed or ended "
        f"more than {SAME_COST:g} above the best cost counts as the limit of time")


def drawn_through(points, left, right):
    """From nothing at the left edge to its last height at the right one."""
    xs, ys = points
    return [left] + xs + [right], [0] + ys + [ys[-1] if ys else 0]


def profiles(found):
    time = profile(found, seconds_at_equal_cost)
    cost = profile(found, lambda runs: {name: max(value, 0) + 1e-12 for name, value in excess(runs).items()})
    worst = max([1e12] + [1.2 * x for xs, _ in cost.values() for x in xs])
    longest = 1.2 * max((x for xs, _ in time.values() for x in xs), default=1)
    return ("<h2>Profiles</h2>"
            + figure([(name, drawn_through(points, 1, longest), "lines", "hv") for name, points in time.items()],
                     "Time at equal cost", "times the fastest", "part of the problems")
            + figure([(name, drawn_through(([1e-12 * x for x in xs], ys), 1e-12, 1e-12 * worst), "lines", "hv")
                      for name, (xs, ys) in cost.items()],
                     "Final cost", "relative excess over the best (1e-12: none)", "part of the problems"))


def growth(found):
    by_backend = {}
    for (_, name, _, _), runs in found.items():
        if name.startswith("walk"):
            for backend, run in runs.items():
                if ended(run):
                    space = name.split("-")[0][len("walk"):]  # walk2d-1000
                    by_backend.setdefault((backend, space), []).append((run["variables"], run["seconds"]))
    if not by_backend:
        return ""
    traces = []
    for (backend, space), points in sorted(by_backend.items()):
        traces.append((f"{backend} {space}", tuple(zip(*sorted(points))), "lines+markers", "linear"))
    return "<h2>Growth</h2>" + figure(traces, "Walks of growing size", "variables", "seconds", y_log=True)


def solved(found, suite):
    rows = []
    for (of_suite, name, loss, start), runs in found.items():
        if of_suite != suite:
            continue
        above = excess(runs)
        for backend, run in sorted(runs.items(), key=lambda item: item[1]["seconds"] or math.inf):
            rows.append((name, loss, start, backend, number(run["cost"], ".9g"), number(above[backend], ".1e"), run["iterations"],
                         number(run["seconds"]), number(run.get("ate_rmse")), run["termination"]))
    return table(["problem", "loss", "start", "back-end", "cost", "above the best", "iterations", "s", "ATE [m]", "ended"], rows,
                 f"Suite {suite}: every run")


def cost_over_time(found, suite):
    """For each problem of the suite: how far each back-end lay above the best final cost, against time."""
    parts = []
    for (of_suite, name, loss, start), runs in found.items():
        traced = {backend: run["trace"] for backend, run in runs.items() if run.get("trace")}
        if of_suite != suite or not traced:
            continue
        best = min(cost for trace in traced.values() for _, cost in trace if cost is not None)
        traces = []
        for backend, trace in sorted(traced.items()):
            points = [(max(time, 1e-6), max((cost - best) / max(abs(best), 1e-300), 1e-12)) for time, cost in trace if cost is not None]
            traces.append((backend, tuple(zip(*points)), "lines+markers", "hv"))
        parts.append(figure(traces, f"{name}, {loss}, start {start}: cost against time", "seconds", "relative excess (1e-12: none)",
                            y_log=True))
    return folded(f"Suite {suite}: cost against time, {len(parts)} problems", parts)


def folded(title, parts):
    return f"<details><summary>{html.escape(title)}</summary>{''.join(parts)}</details>" if parts else ""


def drawings(folder, suite):
    """The drawings of a suite that bench left beside its results, of the newest commit among them."""
    found = []
    place = os.path.join(folder, "drawings")
    for name in sorted(os.listdir(place)) if os.path.isdir(place) else []:
        if name.endswith(".json"):
            with open(os.path.join(place, name), encoding="utf-8") as file:
                drawing = json.load(file)
            if drawing["suite"] == suite:
                found.append(drawing)
    return found


def from_above(drawing):
    import plotly.graph_objects as go
    drawn = go.Figure()
    ends = [line[i] if i is not None else None for line in drawing["rejected"] for i in (0, 2, None)]
    heights = [line[i] if i is not None else None for line in drawing["rejected"] for i in (1, 3, None)]
    if ends:
        drawn.add_trace(go.Scatter(x=ends, y=heights, name=f"outliers ({len(drawing['rejected'])})", mode="lines",
                                   line={"color": COLOURS[1], "dash": "dot", "width": 1}))
    for i, track in enumerate(drawing["tracks"]):
        mode = "lines" if track["is_way"] else "markers"
        colour = COLOURS[(0, 2, 3, 4, 5, 6)[i % 6]]
        if track["truth"]:
            drawn.add_trace(go.Scatter(x=[p[0] for p in track["truth"]], y=[p[1] for p in track["truth"]], name=f"{track['name']}, true",
                                       mode=mode, line={"color": "#808080", "dash": "dot"}, marker={"color": "#808080", "symbol": "x"}))
        drawn.add_trace(go.Scatter(x=[p[0] for p in track["estimate"]], y=[p[1] for p in track["estimate"]], name=track["name"], mode=mode,
                                   line={"color": colour}, marker={"color": colour}))
    drawn.update_yaxes(scaleanchor="x")
    title = f"{stem(drawing['file'])}, {drawing['loss']}, start {drawing['start']}"
    return shown(drawn, f"{title}: {drawing['backend']}, cost {number(drawing['cost'], '.6g')}", "x [m]", "y [m]")


def errors_over_time(line):
    import plotly.graph_objects as go
    times, errors, bands = zip(*line["errors"])
    drawn = go.Figure()
    around = bands + tuple(-band for band in bands[::-1])
    drawn.add_trace(go.Scatter(x=times + times[::-1], y=around, name="3σ", fill="toself", mode="lines",
                               line={"color": COLOURS[5], "width": 1}, fillcolor="rgba(86,180,233,0.3)"))
    drawn.add_trace(go.Scatter(x=times, y=errors, name="error", mode="lines", line={"color": COLOURS[1]}))
    within = sum(abs(error) <= band for error, band in zip(errors, bands))
    return shown(drawn, f"{line['window']}: {within} of {len(errors)} within 3σ", "seconds", "error of x [m]")


def robust(lines):
    settings = {}
    for line in lines:
        settings.setdefault((line["graph"], line["kind"], line["share"], line["method"]), []).append(line)
    rows = []
    for (graph, kind, share, method), runs in settings.items():
        ate = [math.inf if run["ate"] is None else run["ate"] for run in runs]
        good = sum(run["success"] if "success" in run else error < 0.1 for run, error in zip(runs, ate))
        rows.append((graph, kind, f"{share:g}", method, f"{good} of {len(runs)}", number(statistics.median(ate)), number(max(ate)),
                     number(statistics.median(run["seconds"] for run in runs))))
    methods = sorted({row[3] for row in rows})
    counted = {method: [run for (_, _, _, name), runs in settings.items() if name == method for run in runs] for method in methods}
    traces = []
    for method in methods:
        ate = [run["ate"] if run["ate"] is not None and run["termination"] != "failed" else math.inf for run in counted[method]]
        traces.append((method, steps_of_profile([max(error, 1e-6) for error in ate], len(ate)), "lines", "hv"))
    return figure(traces, "Error over all runs", "ATE [m] (1e-6: none)", "part of the runs") + table(
        ["graph", "kind", "share", "method", "success", "ATE, median [m]", "worst", "s, median"], rows,
        "Suite robust: by setting and method")


def paper(suite, lines):
    cells = {}
    for line in lines:
        if "row" in line and line.get("error") is not None:
            cells.setdefault((line["table"], line["column"], line["row"]), []).append(line)
    rows = [(place[0], place[1], place[2], number(statistics.median(run["error"] for run in runs)), len(runs))
            for place, runs in cells.items()]
    return table(["table", "column", "estimator", "error, median", "seeds"], rows, f"Suite {suite}: the paper's estimators and ours")


def plain(suite, lines):
    titles = list(dict.fromkeys(key for line in lines for key, value in line.items()
                                if isinstance(value, (int, float, str, bool)) and key not in ("suite", "commit")))
    rows = [[number(line.get(key)) if isinstance(line.get(key), float) else line.get(key, "–") for key in titles] for line in lines]
    return table(titles, rows, f"Suite {suite}")


STYLE = """
:root { color-scheme: light dark; --ink: #1b1b1b; --paper: #ffffff; --line: #c8c8c8; }
@media (prefers-color-scheme: dark) { :root { --ink: #ececec; --paper: #161616; --line: #4a4a4a; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 70rem; margin: auto; padding: 1rem; }
.lead { font-size: 1.25rem; } .wide { overflow-x: auto; margin: 1rem 0; } figure { margin: 1rem 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: .2rem .6rem; text-align: left; white-space: nowrap; }
td { text-align: right; } summary { cursor: pointer; padding: .5rem 0; }
@media print { body { max-width: none; } .wide { overflow: visible; } }
"""

# A figure that was hidden when it was drawn has no width before it is told to look again.
OPENED = """for (const part of document.querySelectorAll('details'))
  part.addEventListener('toggle', () => window.dispatchEvent(new Event('resize')));"""


def page(suites, torn, folder):
    import plotly
    from plotly.offline import get_plotlyjs
    found = problems(suites)
    lines = [line for of_suite in suites.values() for line in of_suite]
    machines = sorted({f"{line['machine']['cpu']}, {line['machine']['cores']} cores" for line in lines if line.get("machine")})
    commits = sorted({str(line.get("commit")) for line in lines})
    parts = [f"<p>Machine: {html.escape('; '.join(machines))}. Commit: {html.escape(', '.join(commits))}. Drawn "
             f"{datetime.date.today().isoformat()} with plotly {plotly.__version__} from {len(lines)} lines.</p>"]
    if torn:
        parts.append(f"<p>Lines that are no JSON object and are left out: {html.escape(', '.join(torn))}.</p>")
    if found:
        parts += [who_wins(found), profiles(found), growth(found)]
    for suite, of_suite in suites.items():
        parts.append(f"<h2>{html.escape(suite)}</h2>")
        if any(key[0] == suite for key in found):
            parts.append(solved(found, suite))
            pictures = [from_above(drawing) for drawing in drawings(folder, suite)]
            parts.append(folded(f"Suite {suite}: the best answers from above, {len(pictures)} problems", pictures))
            parts.append(cost_over_time(found, suite))
        elif suite == "robust":
            parts.append(robust(of_suite))
        elif suite.startswith("papers"):
            parts.append(paper(suite, of_suite))
        else:
            parts.append(plain(suite, of_suite))
            parts += [errors_over_time(line) for line in of_suite if line.get("errors")]
    return ("<!doctype html><html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width, initial-scale=1'>"
            f"<title>holdfast: what was measured</title><style>{STYLE}</style><link rel=icon href='data:,'>"
            f"<script>{get_plotlyjs()}</script></head>"
            f"<body><main><h1>holdfast: what was measured</h1>{''.join(parts)}</main><script>{OPENED}</script></body></html>")


def main(arguments):
    folder = arguments[0] if arguments else "bench-out"
    out = arguments[1] if len(arguments) > 1 else os.path.join(folder, "index.html")
    if not os.path.isdir(folder):
        sys.exit(f"report: there is no directory {folder}; run scripts/bench first, or name the directory of its results")
    suites, torn = read(folder)
    if not suites:
        sys.exit(f"report: {folder} holds no results (*.jsonl); run scripts/bench first")
    try:
        text = page(suites, torn, folder)
    except ModuleNotFoundError as missing:
        sys.exit(f"report: {missing}; run scripts/report, which installs it, or pip install plotly")
    try:
        with open(out + ".part", "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(out + ".part", out)
    except OSError as error:
        sys.exit(f"report: cannot write {out}: {error.strerror}; name another page as the second argument")
    print(f"report: {out}, {len(text) / 1e6:.1f} MB")


if __name__ == "__main__":
    main(sys.argv[1:])
