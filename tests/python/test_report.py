"""The page of benchmarks/report: its numbers are those of the lines, and it fetches nothing."""
import csv
import importlib.util
import json
import math
import pathlib
import re
import subprocess
import sys

import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "benchmarks" / "report" / "report.py"
specification = importlib.util.spec_from_file_location("report", SCRIPT)
report = importlib.util.module_from_spec(specification)
specification.loader.exec_module(report)
import figures as figures_of_page  # noqa: E402  (beside report.py)
import results  # noqa: E402


def run(file, backend, cost, seconds, **more):
    line = {"file": f"range/{file}.pyfg", "backend": backend, "loss": "squared", "start": "odometry", "cost": cost, "iterations": 7,
            "termination": "converged", "seconds": seconds, "ate_rmse": 0.125, "variables": 10, "threads": 1, "time_limit": 60.0,
            "suite": "data", "commit": "abc", "tolerance": 1e-10, "machine": MACHINE}
    return {**line, **more}


MACHINE = {"cpu": "a processor", "cores": 2, "compiler": "a compiler", "holdfast": "0.2.0", "eigen": "3.4.0"}
LINES = [run("one", "irls", 5.0, 0.11), run("one", "ceres", 5.0, 0.25), run("two", "irls", 3.0, 0.03), run("two", "ceres", 3.1, 0.01),
         run("three", "irls", 2.0, 0.5), run("three", "ceres", None, 0.2, termination="failed")]


def write(folder, suite, lines):
    (folder / f"{suite}.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")


def test_who_stops_above_the_best_cost_or_fails_has_not_arrived():
    found = report.problems({"data": LINES})
    times = [report.seconds_at_equal_cost(runs) for runs in found.values()]
    assert times == [{"irls": 0.11, "ceres": 0.25}, {"irls": 0.03, "ceres": math.inf}, {"irls": 0.5, "ceres": math.inf}]


def test_the_shifted_geometric_mean_by_hand():
    # (0.11 + 0.01)(0.03 + 0.01) = 0.0048; its root less 0.01
    assert results.shifted_geometric_mean([0.11, 0.03], 60) == pytest.approx(math.sqrt(0.0048) - 0.01, rel=1e-12)
    assert results.shifted_geometric_mean([math.inf], 60) == pytest.approx(60, rel=1e-12)


def test_the_ranking_counts_failures_as_the_limit_of_time():
    rows = report.ranking(report.problems({"data": LINES}))
    assert [(row[0], row[2], row[3], row[4]) for row in rows] == [("irls", 3, 3, 3), ("ceres", 1, 3, 0)]
    assert rows[1][1] == pytest.approx((0.26 * 60.01 * 60.01) ** (1 / 3) - 0.01, rel=1e-12)


def test_who_wins_where_and_by_what_factor():
    said = report.where(report.problems({"data": LINES}))
    rows = [re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", row) for row in re.findall(r"<tr>(.*?)</tr>", said)][1:]
    assert [(row[0], *row[3:]) for row in rows] == [("data: one", "irls", "0.11", "ceres", "2.27"),
                                                    ("data: two", "irls", "0.03", "nobody else", "∞"),
                                                    ("data: three", "irls", "0.5", "nobody else", "∞")]


def test_a_profile_reaches_one_only_where_all_arrived():
    points = report.profile(report.problems({"data": LINES}), report.seconds_at_equal_cost)
    assert points["irls"] == ([1, 1, 1], [1 / 3, 2 / 3, 1])
    assert points["ceres"] == ([0.25 / 0.11], [1 / 3])


def test_walks_of_growing_size_are_a_line_a_back_end_and_space():
    pytest.importorskip("plotly")
    walks = [{**run("", "irls", 1.0, seconds), "file": f"walk{space}d-{poses}", "variables": poses}
             for space in (2, 3) for poses, seconds in ((3000, 0.3), (1000, 0.1))]
    drawn = report.growth(report.problems({"pose-graph": walks}))
    assert drawn.count('"name":"irls 2d"') == 1 and drawn.count('"name":"irls 3d"') == 1
    assert drawn.index("1000") < drawn.index("3000")  # by size
    assert report.growth(report.problems({"data": LINES})) == ""


def test_only_the_newest_commit_counts_and_torn_lines_are_named(tmp_path):
    write(tmp_path, "data", [run("old", "irls", 1.0, 1.0, commit="before")] + LINES)
    with open(tmp_path / "data.jsonl", "a", encoding="utf-8") as file:
        file.write('[1, 2]\n{"file": "torn')
    suites, torn = report.read(tmp_path)
    assert suites == {"data": LINES} and torn == ["data.jsonl:8", "data.jsonl:9"]


def test_the_page_holds_the_numbers_and_fetches_nothing(tmp_path):
    pytest.importorskip("plotly")
    write(tmp_path, "data", LINES)
    write(tmp_path, "papers-a", [{"suite": "papers-a", "table": "Table <I>", "column": "1 %", "row": "KF", "seed": seed, "error": error,
                                  "commit": "abc", "machine": MACHINE} for seed, error in ((1, 6.5), (2, 7.5))])
    done = subprocess.run([sys.executable, str(SCRIPT), str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert len(page) < 15e6
    body = page[page.index("<body>"):]
    for cell in ("<td>3.1</td>", "<td>0.11</td>", "<td>3.3e-02</td>", "<td>∞</td>", "<td>failed</td>", "<td>3 of 3</td>", "<td>7</td>"):
        assert cell in body
    assert "Table &lt;I&gt;" in body and "Table <I>" not in body
    head = page[:page.index("<script>")]
    assert not re.search(r"(src|href)=['\"]?https?:", head + re.sub(r"<script.*?</script>", "", body, flags=re.S))


def test_other_libraries_are_shown_by_ratio(tmp_path):
    pytest.importorskip("plotly")
    write(tmp_path, "peers", [{"suite": "peers", "problem": "a.g2o", "method": method, "seconds": seconds, "cost": 10.0}
                              for method, seconds in (("holdfast irls", 2.0), ("GTSAM", 9.0), ("GTSAM, dogleg", 7.0), ("g2o", 26.0))])
    assert report.main([str(tmp_path)]) is None
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "<th scope=row>a</th><td>1.0</td><td>3.5</td><td>13</td>" in page


def test_a_folder_without_results_is_refused_with_a_cure(tmp_path):
    done = subprocess.run([sys.executable, str(SCRIPT), str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "run scripts/bench first" in done.stderr


def test_a_page_that_cannot_be_written_is_named(tmp_path):
    pytest.importorskip("plotly")
    write(tmp_path, "data", LINES)
    page = tmp_path / "absent" / "page.html"
    done = subprocess.run([sys.executable, str(SCRIPT), str(tmp_path), str(page)], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and f"cannot write {page}" in done.stderr and "Traceback" not in done.stderr


def drawing(file):
    return {"tracks": [{"name": "A", "is_way": True, "estimate": [[0, 0], [1, 0.5]], "truth": [[0, 0], [1, 0]]},
                       {"name": "L", "is_way": False, "estimate": [[4, 4.25]], "truth": []}],
            "rejected": [[0, 0, 4, 4.25]], "ellipses": [[1, 0.5, 0.04, 0, 0.01]],
            "suite": "data", "file": file, "loss": "squared", "start": "odometry", "backend": "irls",
            "cost": 5.0}


def figures(page):
    """The traces that the page draws: [[{x, y, name, …}]]."""
    return [json.loads(text)["data"] for text in re.findall(r"<script type='application/json'>(.*?)</script>", page)]


def whole_page(tmp_path):
    traced = [run("one", "irls", 5.0, 0.11, trace=[[0.0, 9.0], [0.05, 5.5], [0.1, 5.0]]),
              run("one", "ceres", 5.0, 0.25, trace=[[0.0, 9.0], [0.2, 5.0]])]
    write(tmp_path, "data", traced + LINES[2:])
    write(tmp_path, "online", [{"window": "w", "anees": 1.0, "errors": [[0.05, 0.5, 2.0], [0.1, -3.0, 2.5]], "suite": "online",
                                "commit": "abc", "machine": MACHINE},
                               {"window": "w", "steps": 20, "over_time": [[1.0, 10.5, 20.0], [2.0, 11.0, 99.0]], "suite": "online",
                                "commit": "abc", "machine": MACHINE}])
    (tmp_path / "drawings").mkdir()
    (tmp_path / "drawings" / "one.json").write_text(json.dumps(drawing("range/one.pyfg")), encoding="utf-8")
    done = subprocess.run([sys.executable, str(SCRIPT), str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return tmp_path / "index.html"


def test_the_figures_hold_the_ways_the_trace_and_the_errors(tmp_path):
    pytest.importorskip("plotly")
    drawn = {trace["name"]: trace for traces in figures(whole_page(tmp_path).read_text(encoding="utf-8")) for trace in traces}
    assert drawn["A"]["x"] == [0, 1] and drawn["A"]["y"] == [0, 0.5] and drawn["A, true"]["y"] == [0, 0]
    assert drawn["L"]["y"] == [4.25] and drawn["L"]["mode"] == "markers"
    assert drawn["outliers (1)"]["x"] == [0, 4, None] and drawn["outliers (1)"]["y"] == [0, 4.25, None]
    assert drawn["error"]["y"] == [0.5, -3.0] and drawn["3σ of x"]["y"] == [2.0, 2.5, -2.5, -2.0]
    last = [trace for traces in figures((tmp_path / "index.html").read_text(encoding="utf-8")) for trace in traces
            if trace["name"] == "irls" and len(trace["x"]) == 3 and trace["mode"] == "lines+markers"]
    assert [round(value, 12) for value in last[-1]["y"]] == [0.8, 0.1, 1e-12] and last[-1]["x"] == [1e-6, 0.05, 0.1]
    assert drawn["median"]["y"] == [10.5, 11.0] and drawn["worst"]["y"] == [20.0, 99.0] and drawn["worst"]["x"] == [1.0, 2.0]
    # 3 sigmas of 0.2 m along x and of 0.1 m along y, round (1, 0.5)
    assert max(x for x in drawn["3σ"]["x"] if x is not None) == 1.6
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    for said in ("1 of 2 within 3", "a processor, 2 cores", "a compiler", "holdfast 0.2.0, Eigen 3.4.0", "tolerance 1e-10"):
        assert said in page


def test_an_ellipse_has_the_axes_of_its_covariance():
    # 45 degrees, 2 m along and 1 m across: xx = yy = (4 + 1) / 2, xy = (4 - 1) / 2
    corners = figures_of_page.ellipse(0, 0, 2.5, 1.5, 2.5, sigmas=1)
    assert corners[0] == pytest.approx((math.sqrt(2), math.sqrt(2)))
    assert corners[figures_of_page.CORNERS // 4] == pytest.approx((-math.sqrt(0.5), math.sqrt(0.5)))


def test_a_table_of_each_suite_is_beside_the_page(tmp_path):
    pytest.importorskip("plotly")
    whole_page(tmp_path)
    with open(tmp_path / "data.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    lines = [json.loads(line) for line in (tmp_path / "data.jsonl").read_text(encoding="utf-8").splitlines()]
    assert len(rows) == len(lines) and "trace" not in rows[0] and "machine" not in rows[0]
    for row, line in zip(rows, lines):
        assert row["backend"] == line["backend"] and float(row["seconds"]) == line["seconds"]
        assert row["cost"] == ("" if line["cost"] is None else str(line["cost"]))
