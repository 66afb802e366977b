#!/usr/bin/env python3
"""One self-contained page of what `holdfast bench` measured, drawn from its lines of JSON alone.

    scripts/report [bench-out [bench-out/index.html]]

On top who wins by what factor at equal cost, then profiles, growth, a table for each suite with its answers from above (of the directory
drawings/), cost against time, errors with their 3σ bands, windows over time, and the papers. Nothing is fetched from any host: plotly's
script is in the page. Of each file only the lines of its newest commit count; they are written as <suite>.csv beside the page, too. Needs
plotly (scripts/report installs it into build/venv)."""
import datetime
import html
import math
import os
import statistics
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from figures import errors_over_time, figure, folded, from_above, number, steps_over_time, table  # noqa: E402
from results import (OURS, SAME_COST, SHIFT, columns, drawings, ended, excess, peers_table, problems, profile, ranking, read,  # noqa: E402
                     seconds_at_equal_cost, stem, steps_of_profile, write_csv)


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


def where(found):
    """Who is the fastest at equal cost, problem by problem, and by what factor before the next."""
    rows = []
    for (suite, name, loss, start), runs in found.items():
        times = sorted((seconds, backend) for backend, seconds in seconds_at_equal_cost(runs).items())
        if not times or math.isinf(times[0][0]):
            rows.append((f"{suite}: {name}", loss, start, "nobody", "–", "–", "–"))
            continue
        lead = times[1][0] / times[0][0] if len(times) > 1 else math.inf
        second = times[1][1] if math.isfinite(lead) else "nobody else"
        rows.append((f"{suite}: {name}", loss, start, times[0][1], number(times[0][0]), second, number(lead, ".2f")))
    return folded(f"Who wins where: {len(rows)} problems", [table(
        ["problem", "loss", "start", "fastest", "s", "next", "times as long"], rows, "The fastest at the best cost, and the next")])


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
                     "Final cost", "excess over the best, relative", "part of the problems"))


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


def pictures(folder, suite):
    parts = []
    for drawing in drawings(folder, suite):
        title = f"{stem(drawing['file'])}, {drawing['loss']}, start {drawing['start']}"
        parts.append(from_above(drawing, f"{title}: {drawing['backend']}, cost {number(drawing['cost'], '.6g')}"))
    return folded(f"Suite {suite}: the best answers from above, with ellipses of 3σ, {len(parts)} problems", parts)


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
    titles = [name for name in columns(lines) if name not in ("suite", "commit")]
    rows = [[number(line.get(key)) if isinstance(line.get(key), float) else line.get(key, "–") for key in titles] for line in lines]
    return table(titles, rows, f"Suite {suite}")


def measured_with(lines):
    """Machines, compilers, versions and options, each once."""
    def each(texts):
        return html.escape("; ".join(sorted(set(texts)))) or "unknown"
    machines = [line["machine"] for line in lines if line.get("machine")]
    options = (("threads", "threads"), ("tolerance", "tolerance"), ("max_iterations", "iterations at most"), ("time_limit", "limit [s]"))
    return "".join(f"<dt>{name}</dt><dd>{each(texts)}</dd>" for name, texts in (
        ("machine", [f"{one['cpu']}, {one['cores']} cores" for one in machines]),
        ("compiler", [one["compiler"] for one in machines if "compiler" in one]),
        ("versions", [f"holdfast {one['holdfast']}, Eigen {one['eigen']}" for one in machines if "holdfast" in one]),
        ("commit", [str(line.get("commit")) for line in lines]),
        ("options", [", ".join(f"{title} {number(line[key], 'g')}" for key, title in options if line.get(key) is not None)
                     for line in lines if "tolerance" in line])))


STYLE = """
:root { color-scheme: light dark; --ink: #1b1b1b; --paper: #ffffff; --line: #c8c8c8; }
@media (prefers-color-scheme: dark) { :root { --ink: #ececec; --paper: #161616; --line: #4a4a4a; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 70rem; margin: auto; padding: 1rem; }
.lead { font-size: 1.25rem; } .wide { overflow-x: auto; margin: 1rem 0; } figure { margin: 1rem 0; } figcaption { font-weight: bold; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: .2rem .6rem; text-align: left; white-space: nowrap; }
td, thead th { text-align: right; } thead th:first-child { text-align: left; } summary { cursor: pointer; padding: .5rem 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0 1rem; } dd { margin: 0; overflow-wrap: anywhere; }
.js-plotly-plot text { fill: var(--ink) !important; }
@page { size: landscape; margin: 1cm; }
@media print {
  th, td { white-space: normal; overflow-wrap: anywhere; padding: .1rem .3rem; }
  :root { --ink: #000000; --paper: #ffffff; --line: #999999; }
  body { max-width: none; font-size: 11px; } .wide { overflow: visible; } button, .modebar { display: none; }
  figure { break-inside: avoid; }
}
"""

# A figure is drawn when it comes into view, and all before the page is printed, when nothing is folded; a table is saved as CSV.
SCRIPT = """
const draw = figure => {
  const place = figure.querySelector('.plot');
  if (place.dataset.drawn) return;
  place.dataset.drawn = 'yes';
  const {data, layout} = JSON.parse(figure.querySelector('script').textContent);
  Plotly.newPlot(place, data, layout, {responsive: true, displaylogo: false});
};
const seen = new IntersectionObserver(entries => {
  for (const entry of entries) if (entry.isIntersecting) { draw(entry.target); seen.unobserve(entry.target); }
}, {rootMargin: '400px'});
const figures = document.querySelectorAll('figure');
figures.forEach(figure => seen.observe(figure));
window.addEventListener('beforeprint', () => {
  document.querySelectorAll('details').forEach(part => { part.open = true; });
  figures.forEach(draw);
});
for (const button of document.querySelectorAll('button.csv'))
  button.addEventListener('click', () => {
    const rows = [...button.parentElement.nextElementSibling.querySelectorAll('tr')];
    const quoted = cell => '"' + cell.textContent.replaceAll('"', '""') + '"';
    const text = rows.map(row => [...row.cells].map(quoted).join(',') + '\\r\\n').join('');
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([text], {type: 'text/csv'}));
    link.download = 'holdfast.csv';
    link.click();
    URL.revokeObjectURL(link.href);
  });
"""


def of_suite(folder, suite, lines, found):
    """What the page says of one suite."""
    if any(key[0] == suite for key in found):
        return [solved(found, suite), pictures(folder, suite), cost_over_time(found, suite)]
    if suite == "robust":
        return [robust(lines)]
    if suite.startswith("papers"):
        return [paper(suite, lines)]
    if suite == "peers":
        caption = (f"Seconds over those of {OURS}, of the fastest method of each library that ends at the best cost (no: none does; "
                   "–: it has no factor for it)")
        return [table(*peers_table(lines), caption), plain(suite, lines)]
    return ([plain(suite, lines)] + [errors_over_time(line) for line in lines if line.get("errors")]
            + [steps_over_time(line) for line in lines if line.get("over_time")])


def page(suites, torn, folder):
    import plotly
    from plotly.offline import get_plotlyjs
    found = problems(suites)
    lines = [line for lines in suites.values() for line in lines]
    parts = []
    if torn:
        parts.append(f"<p>Lines that are no JSON object and are left out: {html.escape(', '.join(torn))}.</p>")
    if found:
        parts += [who_wins(found), where(found), profiles(found), growth(found)]
    for suite, its_lines in suites.items():
        parts.append(f"<h2>{html.escape(suite)}</h2>")
        parts += of_suite(folder, suite, its_lines, found)
    parts.append(f"<h2>Measured with</h2><dl>{measured_with(lines)}<dt>drawn</dt><dd>{datetime.date.today().isoformat()} with plotly "
                 f"{plotly.__version__} from {len(lines)} lines</dd></dl>")
    return ("<!doctype html><html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width, initial-scale=1'>"
            f"<title>holdfast: what was measured</title><style>{STYLE}</style><link rel=icon href='data:,'>"
            f"<script>{get_plotlyjs()}</script></head>"
            f"<body><main><h1>holdfast: what was measured</h1>{''.join(parts)}</main><script>{SCRIPT}</script></body></html>")


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
        for suite, lines in suites.items():
            write_csv(os.path.join(os.path.dirname(out), f"{suite}.csv"), lines)
    except OSError as error:
        sys.exit(f"report: cannot write {out}: {error.strerror}; name another page as the second argument")
    print(f"report: {out}, {len(text) / 1e6:.1f} MB")


if __name__ == "__main__":
    main(sys.argv[1:])
