"""Draws docs/plaza2.svg, README's picture: plaza2 with every tenth range 5 to 30 m too long, under a squared loss and as gnc-irls answers.

  PYTHONPATH=build/release/python python3 docs/site/first_picture.py $HOLDFAST_DATA/range/plaza2.pyfg docs/plaza2.svg
"""
import pathlib
import sys
import tempfile

import numpy as np

import holdfast as hf

WIDTH, HEIGHT, TOP = 380, 330, 44


def spoilt(path, seed=7):
    """(lines of the file with lies, which of its ranges lie)"""
    rng, lines = np.random.default_rng(seed), pathlib.Path(path).read_text(encoding="utf-8").splitlines()
    ranges = [i for i, line in enumerate(lines) if line.startswith("EDGE_RANGE")]
    lies = rng.choice(len(ranges), len(ranges) // 10, replace=False)
    for n in lies:
        words = lines[ranges[n]].split()
        words[4] = str(float(words[4]) + rng.uniform(5, 30))
        lines[ranges[n]] = " ".join(words)
    return lines, {int(n) for n in lies}


class Answer:
    """Of one back-end: ways and beacons, laid onto the truth by a rigid motion."""

    def __init__(self, path, loss, backend):
        self.graph, self.values = hf.read_problem(path, loss=hf.Loss(loss), start="odometry")
        summary = hf.make_backend(backend).solve(self.graph, self.values)
        if not summary.usable:
            raise SystemExit(f"{path}: {summary}")
        truth = hf.positions(hf.read_problem(path)[1])
        places = {agent: points for agent, (points, _) in hf.positions(self.values).items()}
        p, q = places["A"], truth["A"][0]
        u, _, vt = np.linalg.svd((p - p.mean(axis=0)).T @ (q - q.mean(axis=0)))
        turn = u @ np.diag([1, np.sign(np.linalg.det(u @ vt))]) @ vt
        self.way, self.beacons = ((places[agent] - p.mean(axis=0)) @ turn + q.mean(axis=0) for agent in ("A", "L"))
        self.truth, self.error = q, np.sqrt(((self.way - q) ** 2).sum(axis=1).mean())
        self.at = {str(key): place for agent, way in (("A", self.way), ("L", self.beacons))
                   for key, place in zip(hf.positions(self.values)[agent][1], way)}

    def ranges(self):
        """[(from, to, whether it is believed)] in the order of the file."""
        return [(*(self.at[str(key)] for key in one.keys), one.weight >= 0.5)
                for one in hf.outlier_report(self.graph, self.values) if one.factor == "Range"]


def svg(path):
    lines, lies = spoilt(path)
    with tempfile.TemporaryDirectory() as folder:
        file = str(pathlib.Path(folder) / "spoilt.pyfg")
        pathlib.Path(file).write_text("\n".join(lines) + "\n", encoding="utf-8")
        squared, ours = Answer(file, "squared", "irls"), Answer(file, "truncated_squares:3", "gnc-irls")
    everything = np.concatenate([squared.way, ours.way, ours.beacons])
    low, high = everything.min(axis=0) - 4, everything.max(axis=0) + 4
    scale = min(WIDTH / (high[0] - low[0]), HEIGHT / (high[1] - low[1]))

    def place(p, panel):
        return f"{20 + panel * (WIDTH + 20) + scale * (p[0] - low[0]):.1f} {TOP + scale * (high[1] - p[1]):.1f}"

    def line(points, panel, colour, width, more=""):
        path = "M" + "L".join(place(p, panel) for p in points)
        return f'<path d="{path}" stroke="{colour}" stroke-width="{width}" {more}/>'

    named = [(a, b) for a, b, believed in ours.ranges() if not believed]
    found = sum(n in lies for n, (_, _, believed) in enumerate(ours.ranges()) if not believed)
    parts = []
    for panel, (answer, colour, title) in enumerate((
            (squared, "#d55e00", f"least squares: {squared.error:.1f} m off"),
            (ours, "#0072b2", f"holdfast: {ours.error:.2f} m off; {found} of {len(lies)} lies named"))):
        parts.append(f'<text x="{20 + panel * (WIDTH + 20) + WIDTH / 2}" y="24" text-anchor="middle" font-size="16">{title}</text>')
        if panel == 1:
            segments = "".join(f"M{place(a, 1)}L{place(b, 1)}" for a, b in named)
            parts.append(f'<path d="{segments}" stroke="#cc79a7" stroke-width="0.5" stroke-opacity="0.6"/>')
        parts.append(line(answer.truth[::8], panel, "#999999", 3))
        parts.append(line(answer.way[::4], panel, colour, 1))
        for beacon in answer.beacons:
            x, y = place(beacon, panel).split()
            parts.append(f'<circle cx="{x}" cy="{y}" r="5" fill="{colour}"/>')
    bottom = TOP + HEIGHT + 22
    for at, colour, width, words in ((20, "#999999", 3, "true way"), (110, "#d55e00", 2, "answer and beacons, squared"),
                                     (345, "#0072b2", 2, "answer and beacons, gnc-irls"), (575, "#cc79a7", 1, "ranges it rejects")):
        parts.append(f'<path d="M{at} {bottom}h22" stroke="{colour}" stroke-width="{width}"/><text x="{at + 28}" y="{bottom + 4}" '
                     f'font-size="12">{words}</text>')
    body = "\n".join(parts).replace("<text", '<text stroke="none" fill="#222222"')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * WIDTH + 60} {bottom + 16}" font-family="sans-serif" fill="none">\n'
            '<title>A robot among four beacons, every tenth range too long: least squares, and holdfast</title>\n'
            f'<rect width="100%" height="100%" fill="#ffffff"/>\n{body}\n</svg>\n')


if __name__ == "__main__":
    pathlib.Path(sys.argv[2]).write_text(svg(sys.argv[1]), encoding="utf-8")
