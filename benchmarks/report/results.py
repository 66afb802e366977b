"""The lines of results that `holdfast bench` keeps: read, put side by side, ranked, written as CSV."""
import csv
import json
import math
import os
import statistics

SAME_COST = 1e-6  # relative: two costs that are one (common/report.hpp, kSameCost)
OURS = "holdfast irls"  # of the lines of benchmarks/peers
SAME_OF_PEERS = 1e-3  # relative: libraries that minimise another cost end a little higher
SHIFT = 0.01  # [s] of the shifted geometric mean: below it, differences hardly count


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


def drawings(folder, suite):
    """The drawings of a suite that bench left beside its results."""
    found = []
    place = os.path.join(folder, "drawings")
    for name in sorted(os.listdir(place)) if os.path.isdir(place) else []:
        if name.endswith(".json"):
            with open(os.path.join(place, name), encoding="utf-8") as file:
                drawing = json.load(file)
            if drawing["suite"] == suite:
                found.append(drawing)
    return found


def peer_ratios(lines):
    """{(problem, library): seconds over ours, of its fastest method that ends at the best cost; infinite: none does}"""
    found = {}
    for problem in dict.fromkeys(line["problem"] for line in lines):
        ended = [line for line in lines if line["problem"] == problem and "seconds" in line]
        if not any(line["method"] == OURS for line in ended):
            continue
        best = min(line["cost"] for line in ended)
        ours = next(line["seconds"] for line in ended if line["method"] == OURS)
        for line in ended:
            key = (problem, line["method"].partition(",")[0])
            arrived = line["cost"] <= (1 + SAME_OF_PEERS) * best
            found[key] = min(found.get(key, math.inf), line["seconds"] / ours if arrived else math.inf)
    return found


def peers_table(lines):
    """(titles, rows) of the ratios. no: no method ends at the best cost; –: it has not the factors, or is not there."""
    found = peer_ratios(lines)
    names = list(dict.fromkeys(line["method"].partition(",")[0] for line in lines))
    rows = []
    for problem in dict.fromkeys(line["problem"] for line in lines):
        cells = [found.get((problem, name)) for name in names]
        rows.append([problem.partition(".")[0]] + ["–" if cell is None else "no" if math.isinf(cell) else f"{cell:.1f}" if cell < 10 else
                                                   f"{cell:,.0f}" for cell in cells])
    return ["problem", *names], rows


def columns(lines):
    """The fields of the lines that are one number or text each, in the order in which they come."""
    return list(dict.fromkeys(key for line in lines for key, value in line.items() if not isinstance(value, (list, dict))))


def write_csv(path, lines):
    """A row a line, without its lists and objects."""
    names = columns(lines)
    with open(path + ".part", "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows([line.get(name) for name in names] for line in lines)
    os.replace(path + ".part", path)
