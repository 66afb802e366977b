"""Draws docs/factors/<header>.svg: residual and cost of a factor of each header, as the Python module computes them.

  PYTHONPATH=build/release/python python3 docs/site/factor_figures.py docs/factors

The page of a factor shows its figure and the code that it is drawn from: the texts below, where t is what is swept.
"""
import math
import pathlib
import sys
from typing import NamedTuple

LOSSES = [("squared", "#777777", ""), ("huber:2", "#0072b2", "6 3"), ("truncated_squares:3", "#d55e00", "2 3")]
COMPONENTS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9"]
WIDTH, HEIGHT, LEFT, GAP, TOP, STEPS = 300, 170, 40, 60, 34, 120
HIGHEST = {"residual": 8.0, "cost": 12.0}  # what is beyond is cut off


class Swept(NamedTuple):
    factor: str
    variables: str  # of t
    low: float
    high: float
    t: str  # what it is


TURN = math.pi
FACTORS = {
    "range": Swept("hf.Range[hf.Point2, hf.Point2](distance=5, sigma=0.5)", "hf.Point2(0, 0), hf.Point2(t, 0)", -10, 10,
                   "x of the second position [m]"),
    "antenna_range": Swept("hf.AntennaRange[hf.Pose2, hf.Point2](distance=4, sigma=0.5, lever_a=[1, 0], lever_b=[0, 0])",
                           "hf.Pose2(0, 0, t), hf.Point2(5, 0)", -TURN, TURN, "heading of the robot [rad]"),
    "antenna_range_with_lever": Swept("hf.AntennaRangeWithLever[hf.Pose2, hf.Point2, hf.Point2, hf.Scalar](distance=4, sigma=0.5)",
                                      "hf.Pose2(0, 0, 0.5), hf.Point2(5, 0), hf.Point2(t, 0), hf.Scalar(0)", -3, 3,
                                      "the antenna's place ahead of the robot's origin [m]"),
    "two_way_range": Swept("hf.TwoWayRange[hf.Pose2, hf.Pose2, hf.Scalar, hf.Scalar](round=1e-3 + 20 / 299792458, reply=1e-3, "
                           "sigma=0.1, speed=299792458, lever_a=[0, 0], lever_b=[0, 0])",
                           "hf.Pose2(0, 0, 0), hf.Pose2(10, 0, 0), hf.Scalar(0), hf.Scalar(t)", -10, 10, "drift of the clocks [ppm]"),
    "time_difference": Swept("hf.TimeDifference[hf.Point2, hf.Point2, hf.Point2](difference=2, sigma=0.5, lever_a=[0, 0])",
                             "hf.Point2(t, 3), hf.Point2(-5, 0), hf.Point2(5, 0)", -4, 2, "x of the receiver [m]"),
    "range_time_offset": Swept("hf.RangeWithTimeOffset[hf.Motion2, hf.Point2, hf.Scalar](distance=4.8, sigma=0.1)",
                               "hf.Motion2([0, 2, 0, 0]), hf.Point2(5, 0), hf.Scalar(t)", -0.5, 0.5, "offset of the clock [s]"),
    "range_ball": Swept("hf.RangeBall[hf.Point2, hf.Point2](distance=5, sigma=0.5)", "hf.Point2(0, 0), hf.Point2(t, 0)", -10, 10,
                        "x of the second position [m]"),
    "missing_distance": Swept("hf.MissingDistance[hf.Point2, hf.Point2](d_prev=5, sigma=0.5, rho=1)", "hf.Point2(0, 0), hf.Point2(t, 0)",
                              -10, 10, "x of the second position [m]"),
    "von_mises_bearing": Swept("hf.VonMisesBearing[hf.Point2, hf.Point2](direction=[1, 0], kappa=10)",
                               "hf.Point2(0, 0), hf.Point2(5 * math.cos(t), 5 * math.sin(t))", -TURN, TURN,
                               "angle between what is seen and what is there [rad]"),
    "antenna_bearing": Swept("hf.AntennaBearingBody[hf.Pose2, hf.Point2](direction=[1, 0], kappa=10, lever_a=[1, 0], lever_b=[0, 0])",
                             "hf.Pose2(0, 0, t), hf.Point2(5, 0)", -TURN, TURN, "heading of the robot [rad]"),
    "range_bearing": Swept("hf.RangeBearing[hf.Point2, hf.Point2](distance=5, sigma=0.5, direction=[1, 0], kappa=10)",
                           "hf.Point2(0, 0), hf.Point2(t, 1)", -10, 10, "x of the second position, 1 m aside [m]"),
    "bearing_ray": Swept("hf.BearingRay[hf.Point2, hf.Point2](direction=[1, 0], sigma=0.5)", "hf.Point2(0, 0), hf.Point2(t, 1)", -5, 5,
                         "x of the second position, 1 m aside [m]"),
    "range_bearing_ball": Swept("hf.RangeBearingBall[hf.Point2, hf.Point2](distance=5, sigma=0.5, direction=[1, 0], kappa=10)",
                                "hf.Point2(0, 0), hf.Point2(t, 0)", -5, 10, "x of the second position [m]"),
    "white_acceleration": Swept("hf.WhiteAcceleration[hf.Motion2].continuous(duration=1, q=0.5)",
                                "hf.Motion2([0, 1, 0, 0]), hf.Motion2([t, 1, 0, 0])", -1, 3, "x after a second at 1 m/s [m]"),
    "white_jerk": Swept("hf.WhiteJerk[hf.Accel2].continuous(duration=1, q=0.5)",
                        "hf.Accel2([0, 1, 0, 0, 0, 0]), hf.Accel2([t, 1, 0, 0, 0, 0])", 0.5, 1.5, "x after a second at 1 m/s [m]"),
    "constant_turn": Swept("hf.ConstantTurn[hf.Motion2].from_covariance(dt=1, omega=0.5, covariance=np.diag([0.1, 0.1, 0.1, 0.1]))",
                           "hf.Motion2([0, 1, 0, 0]), hf.Motion2([1, math.cos(t), 0.25, math.sin(t)])", -TURN / 2, TURN / 2,
                           "direction of the velocity a second later [rad]"),
    "coordinated_turn": Swept("hf.CoordinatedTurn[hf.Turning2](dt=1, q=0.5, q_turn=0.1)",
                              "hf.Turning2([0, 1, 0, 0, t]), hf.Turning2([1, math.cos(0.5), 0.25, math.sin(0.5), 0.5])", -1, 2,
                              "turn rate before a turn by 0.5 rad/s [rad/s]"),
    "position_step": Swept("hf.PositionStep[hf.Point2, hf.Point2](beta=0.5)", "hf.Point2(0, 0), hf.Point2(t, 0)", -3, 3,
                           "x of the later position [m]"),
    "prior": Swept("hf.Prior[hf.Pose2].from_sigmas(hf.Pose2(0, 0, 0), [0.5, 0.5, 0.5])", "hf.Pose2(0.5, 0, t),", -2 * TURN, 2 * TURN,
                   "heading [rad]"),
    "between": Swept("hf.Between[hf.Pose2].from_sigmas(hf.Pose2(2, 0, 0), [0.5, 0.5, 0.5])", "hf.Pose2(0, 0, t), hf.Pose2(2, 0, 0)",
                     -TURN, TURN, "heading of the first pose [rad]"),
    "relative_point": Swept("hf.RelativePoint[hf.Pose2, hf.Point2].from_sigmas([2, 1], [0.5, 0.5])",
                            "hf.Pose2(0, 0, t), hf.Point2(2, 1)", -TURN, TURN, "heading of the robot [rad]"),
    "huber_measurement": Swept("hf.HuberMeasurement[hf.Motion2].of_position(z=[-5, 0], p_agent=[0, 0], Q=np.eye(2))",
                               "hf.Motion2([t, 0, 1, 0]),", 0, 10, "x of the target, 1 m aside [m]"),
}


def problem(swept, t, loss):
    import numpy as np

    import holdfast as hf
    names = {"hf": hf, "np": np, "math": math, "t": t}
    graph, values, keys = hf.Graph(), hf.Values(), []
    for i, variable in enumerate(eval(f"[{swept.variables}]", names)):
        keys.append(f"x{i}")
        values.insert(keys[-1], variable)
    graph.add(eval(swept.factor, names), keys, loss=loss)
    return graph, values


def residual(swept, t):
    """Whitened, component by component."""
    import holdfast as hf
    return [float(number) for number in hf.outlier_report(*problem(swept, t, "squared"))[0].whitened]


def cost(swept, t, loss):
    """½ρ"""
    graph, values = problem(swept, t, loss)
    return graph.cost(values)


def steps(swept):
    """Values of t that hit neither 0 nor the ends, where a factor may not be smooth."""
    return [swept.low + (i + 0.5) * (swept.high - swept.low) / STEPS for i in range(STEPS)]


class Panel:
    def __init__(self, number, swept, low, high):
        self.left, self.swept, self.low, self.high = LEFT + number * (WIDTH + GAP), swept, low, high

    def x(self, t):
        return self.left + (t - self.swept.low) / (self.swept.high - self.swept.low) * WIDTH

    def y(self, value):
        return TOP + HEIGHT - (value - self.low) / (self.high - self.low) * HEIGHT

    def frame(self, title):
        parts = [f'<text x="{self.left + WIDTH / 2}" y="16" text-anchor="middle">{title}</text>',
                 f'<path d="M{self.left} {TOP}V{TOP + HEIGHT}M{self.left} {self.y(0):.1f}h{WIDTH}" stroke="#bbbbbb"/>']
        for i in range(5):
            t = self.swept.low + i * (self.swept.high - self.swept.low) / 4
            parts.append(f'<text x="{self.x(t):.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{t:.3g}</text>')
        for value in sorted({self.low, 0.0, self.high}):
            parts.append(f'<text x="{self.left - 6}" y="{self.y(value) + 4:.1f}" text-anchor="end">{value:.2g}</text>')
        parts.append(f'<text x="{self.left + WIDTH / 2}" y="{TOP + HEIGHT + 34}" text-anchor="middle">{self.swept.t}</text>')
        return parts

    def line(self, values, colour, dash=""):
        """What lies beyond the panel is left out."""
        path, inside = "", False
        for t, value in zip(steps(self.swept), values):
            if self.low <= value <= self.high:
                path += f"{'L' if inside else 'M'}{self.x(t):.1f} {self.y(value):.1f}"
            inside = self.low <= value <= self.high
        return f'<path d="{path}" stroke="{colour}" stroke-width="1.6" stroke-dasharray="{dash}"/>'


def svg(name):
    swept = FACTORS[name]
    columns = list(zip(*(residual(swept, t) for t in steps(swept))))
    reach = min(max(abs(value) for column in columns for value in column), HIGHEST["residual"])
    one_sided = min(value for column in columns for value in column) >= 0
    left = Panel(0, swept, 0 if one_sided else -reach, reach)
    parts = left.frame("residual r [sigmas]")
    parts += [left.line(column, COMPONENTS[i % len(COMPONENTS)]) for i, column in enumerate(columns)]
    costs = {loss: [cost(swept, t, loss) for t in steps(swept)] for loss, _, _ in LOSSES}
    right = Panel(1, swept, 0, min(max(costs["squared"]), HIGHEST["cost"]))
    parts += right.frame("cost ½ρ")
    parts += [right.line(costs[loss], colour, dash) for loss, colour, dash in LOSSES]
    bottom = TOP + HEIGHT + 56
    for i, (loss, colour, dash) in enumerate(LOSSES):
        at = right.left + (0, 80, 155)[i]
        parts.append(f'<path d="M{at} {bottom}h22" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>'
                     f'<text x="{at + 26}" y="{bottom + 4}">{loss}</text>')
    for i in range(len(columns) if len(columns) > 1 else 0):
        at = left.left + 48 * i
        parts.append(f'<path d="M{at} {bottom}h22" stroke="{COMPONENTS[i]}" stroke-width="2"/><text x="{at + 26}" y="{bottom + 4}">r{i + 1}'
                     '</text>')
    body = "\n".join(parts).replace("<text", '<text stroke="none" fill="#222222"')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {LEFT + 2 * WIDTH + GAP + 20} {bottom + 14}" font-family="sans-serif" '
            f'font-size="12" fill="none">\n<title>{words(name)}</title>\n{body}\n</svg>\n')


def words(name):
    return f"Residual and cost of {name.replace('_', ' ')} over {FACTORS[name].t.split(' [')[0]}"


def code(name):
    """The lines of Python that the figure is drawn from."""
    swept = FACTORS[name]
    keys = ", ".join(f'"x{i}"' for i in range(swept.variables.rstrip(",").count("hf.")))
    return f"graph.add({swept.factor}, [{keys}], loss=\"huber:2\")  # drawn at {swept.variables.rstrip(',')}"


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    for header in FACTORS:
        (folder / f"{header}.svg").write_text(svg(header), encoding="utf-8")
