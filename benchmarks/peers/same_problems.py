#!/usr/bin/env python3
"""The same problems through the libraries that have Python wheels: holdfast, GTSAM, Ceres (pyceres), g2o (g2opy), SciPy.

    scripts/bench --peers                    # installs them into build/peers-venv, runs this, writes bench-out/peers.jsonl
    PYTHONPATH=build/release/python build/peers-venv/bin/python benchmarks/peers/same_problems.py FILE.g2o … FILE.pyfg …

What is equal. The start: the file's vertices. The rule: a step that lowers the cost by less than 1e-6 of it is the last, at most 100. One
thread. The cost: every answer is read back, and scored by holdfast's Graph::cost; the cost of the start as the library itself sees it
has to agree with it to 1e-6, or the line says by how much it does not. Seconds are of the solve alone, without reading the file or making
the graph; the median of five, the libraries in turn.

What is not. GTSAM and g2o run Levenberg-Marquardt, Gauss-Newton and dogleg, a line each: none of them is the best everywhere. GTSAM's
relative poses have the residual of the group's logarithm, and g2o's in space that of a quaternion's vector part, so that their costs are
others (`other_cost`: by what part at the start). pyceres has no pose graph factor: its residuals are Python functions, one call each, which
is what its users have. g2opy has no edge for a range. SciPy: least_squares (trf, lsmr) with a sparse Jacobian, in the plane.
`overhead`: the seconds of a solve of two poses from their answer."""
import argparse
import json
import math
import pathlib
import statistics
import sys
import time

import numpy as np

import holdfast as hf

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "report"))
from results import OURS, peers_table  # noqa: E402

TOLERANCE, ITERATIONS = 1e-6, 100


def symmetric(numbers, dim):
    full = np.zeros((dim, dim))
    full[np.triu_indices(dim)] = numbers
    return full + np.triu(full, 1).T


class Problem:
    """What every library is given: poses, points, edges, ranges, the pose that is held."""

    def __init__(self, path):
        self.path = path
        is_range = path.endswith(".pyfg")
        self.loss = hf.Huber(2) if is_range else hf.Squared()
        self.graph, self.start = hf.read_problem(path, loss=self.loss)
        keys = list(self.start)
        self.poses = [key for key in keys if isinstance(self.start[key], (hf.Pose2, hf.Pose3))]
        self.points = [key for key in keys if key not in set(self.poses)]
        self.dim = 3 if isinstance(self.start[self.poses[0]], hf.Pose2) else 6
        self.edges, self.ranges = [], []
        with open(path, encoding="utf-8") as lines:
            for words in map(str.split, lines):
                if not words:
                    continue
                if is_range and words[0] == "EDGE_SE2":
                    covariance = symmetric([float(word) for word in words[7:]], 3)
                    self.edges.append((hf.Key(words[2]), hf.Key(words[3]), [float(w) for w in words[4:7]], np.linalg.inv(covariance)))
                elif words[0] == "EDGE_RANGE":
                    self.ranges.append((hf.Key(words[2]), hf.Key(words[3]), float(words[4]), math.sqrt(float(words[5]))))
                elif words[0] in ("EDGE_SE2", "EDGE_SE3:QUAT"):
                    n = 3 if words[0] == "EDGE_SE2" else 7
                    numbers = [float(word) for word in words[3:]]
                    information = symmetric(numbers[n:], self.dim)
                    if self.dim == 6:  # of half the angle, as g2o has it
                        information[3:, :] /= 2
                        information[:, 3:] /= 2
                    self.edges.append((hf.Key(f"x{words[1]}"), hf.Key(f"x{words[2]}"), numbers[:n], information))
        self.held = next((key for key in self.poses if self.graph.is_fixed(key)), self.poses[0])
        self.is_fixed = self.graph.is_fixed(self.held)  # else a prior at the start holds it, with the noise of the first edge
        self.id = {key: i for i, key in enumerate(keys)}

    def score(self, answer):
        return self.graph.cost(answer)


def two_poses(problem):
    """The first edge alone, at its answer: what a call costs."""
    small = object.__new__(Problem)
    a, b, z, information = problem.edges[0]
    small.path, small.loss, small.poses, small.points, small.dim = "", problem.loss, [a, b], [], problem.dim
    small.edges, small.ranges, small.held, small.is_fixed, small.id = [(a, b, z, information)], [], a, True, {a: 0, b: 1}
    small.start, small.graph = hf.Values(), hf.Graph()
    kind = hf.Pose2 if problem.dim == 3 else hf.Pose3
    measured = kind(*z) if problem.dim == 3 else kind(z[:3], z[3:])
    small.start.insert(a, problem.start[a])
    small.start.insert(b, problem.start[a] * measured)
    small.graph.fix(a)
    small.graph.add(hf.Between[kind].from_information(measured, information), [a, b])
    return small


class Holdfast:
    name, version = OURS, "this tree"

    def __init__(self, problem):
        self.problem = problem

    def first_cost(self):
        return self.problem.score(self.problem.start)

    def solve(self):
        values = hf.Values(self.problem.start)
        backend = hf.make_backend("irls", cost_tolerance=TOLERANCE, max_iterations=ITERATIONS)
        begin = time.perf_counter()
        summary = backend.solve(self.problem.graph, values)
        return time.perf_counter() - begin, values, summary.iterations


class Gtsam:
    name, method = "GTSAM", "LevenbergMarquardt"

    def __init__(self, problem):
        import gtsam

        self.gtsam, self.problem, self.version = gtsam, problem, "4.3"
        self.graph, self.values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        flat = problem.dim == 3
        noise = gtsam.noiseModel
        for key in problem.poses:
            self.values.insert(problem.id[key], self.pose(problem.start[key]))
        for key in problem.points:
            self.values.insert(problem.id[key], problem.start[key].value)
        order = [3, 4, 5, 0, 1, 2]
        between = gtsam.BetweenFactorPose2 if flat else gtsam.BetweenFactorPose3
        for a, b, z, information in problem.edges:
            model = noise.Gaussian.Information(information if flat else information[np.ix_(order, order)])
            self.graph.add(between(problem.id[a], problem.id[b], self.measured(z), model))
        huber = noise.mEstimator.Huber.Create(2.0)
        for a, b, distance, sigma in problem.ranges:
            model = noise.Robust.Create(huber, noise.Isotropic.Sigma(1, sigma))
            self.graph.add(gtsam.RangeFactor2D(problem.id[a], problem.id[b], distance, model))
        held = self.pose(problem.start[problem.held])
        model = noise.Isotropic.Sigma(problem.dim, 1e-6) if problem.is_fixed else noise.Gaussian.Information(problem.edges[0][3])
        self.graph.add((gtsam.PriorFactorPose2 if flat else gtsam.PriorFactorPose3)(problem.id[problem.held], held, model))

    def pose(self, x):
        g = self.gtsam
        return g.Pose2(*x.p, x.angle) if self.problem.dim == 3 else g.Pose3(g.Rot3.Quaternion(x.q[3], *x.q[:3]), x.p)

    def measured(self, z):
        g = self.gtsam
        return g.Pose2(*z) if self.problem.dim == 3 else g.Pose3(g.Rot3.Quaternion(z[6], *z[3:6]), np.array(z[:3]))

    def first_cost(self):
        return self.graph.error(self.values)

    def solve(self):
        parameters = getattr(self.gtsam, f"{self.method}Params")()
        parameters.setRelativeErrorTol(TOLERANCE)
        parameters.setAbsoluteErrorTol(0)
        parameters.setMaxIterations(ITERATIONS)
        begin = time.perf_counter()
        optimizer = getattr(self.gtsam, f"{self.method}Optimizer")(self.graph, self.values, parameters)
        answer = optimizer.optimize()
        seconds = time.perf_counter() - begin
        values = hf.Values(self.problem.start)
        for key in self.problem.poses:
            i = self.problem.id[key]
            if self.problem.dim == 3:
                x = answer.atPose2(i)
                values.update(key, hf.Pose2(x.x(), x.y(), x.theta()))
            else:
                x = answer.atPose3(i)
                q = x.rotation().toQuaternion()
                values.update(key, hf.Pose3(x.translation(), [q.x(), q.y(), q.z(), q.w()]))
        for key in self.problem.points:
            values.update(key, hf.Point2(answer.atPoint2(self.problem.id[key])))
        return seconds, values, optimizer.iterations()


class GtsamGaussNewton(Gtsam):
    name, method = "GTSAM, Gauss-Newton", "GaussNewton"


class GtsamDogleg(Gtsam):
    name, method = "GTSAM, dogleg", "Dogleg"


def relative_residual(x, y, z, root):
    """whitened (R_xᵀ(p_y − p_x) − z, the angle), and its derivatives by x and y, in (position, angle)."""
    c, s = math.cos(x[2]), math.sin(x[2])
    dx, dy = y[0] - x[0], y[1] - x[1]
    e = np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], math.remainder(y[2] - x[2] - z[2], 2 * math.pi)])
    cz, sz = math.cos(z[2]), math.sin(z[2])
    turn = np.array([[cz, sz, 0], [-sz, cz, 0], [0, 0, 1]])  # the error in the frame of the measured pose, as holdfast and GTSAM have it
    J_x = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0, 0, -1.0]])
    J_y = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    return root @ turn @ e, root @ turn @ J_x, root @ turn @ J_y


class Pyceres:
    name = "Ceres by pyceres"

    def __init__(self, problem):
        import pyceres

        if problem.dim != 3:
            raise NotImplementedError("no factor of its own in space; Python functions in the plane alone")
        self.ceres, self.problem, self.version = pyceres, problem, "2.6"
        self.roots = [np.linalg.cholesky(information).T for *_, information in problem.edges]

    def make(self):
        ceres, problem = self.ceres, self.problem

        class Relative(ceres.CostFunction):
            def __init__(self, z, root):
                super().__init__()
                self.z, self.root = z, root
                self.set_num_residuals(3)
                self.set_parameter_block_sizes([3, 3])

            def Evaluate(self, parameters, residuals, jacobians):
                r, J_x, J_y = relative_residual(*parameters, self.z, self.root)
                residuals[:] = r
                if jacobians is not None:
                    for J, out in zip((J_x, J_y), jacobians):
                        if out is not None:
                            out[:] = J.ravel()
                return True

        class Range(ceres.CostFunction):
            def __init__(self, distance, sigma):
                super().__init__()
                self.distance, self.sigma = distance, sigma
                self.set_num_residuals(1)
                self.set_parameter_block_sizes([3, 2])

            def Evaluate(self, parameters, residuals, jacobians):
                pose, point = parameters
                step = point - pose[:2]
                length = math.hypot(*step)
                residuals[0] = (length - self.distance) / self.sigma
                if jacobians is not None:
                    u = step / (length * self.sigma)
                    if jacobians[0] is not None:
                        jacobians[0][:] = [-u[0], -u[1], 0]
                    if jacobians[1] is not None:
                        jacobians[1][:] = u
                return True

        class Prior(ceres.CostFunction):
            def __init__(self, mean, root):
                super().__init__()
                self.mean, self.root = mean, root
                self.set_num_residuals(3)
                self.set_parameter_block_sizes([3])

            def Evaluate(self, parameters, residuals, jacobians):
                r, _, J = relative_residual(self.mean, parameters[0], np.zeros(3), self.root)
                residuals[:] = r
                if jacobians is not None and jacobians[0] is not None:
                    jacobians[0][:] = J.ravel()
                return True

        x = {key: np.array([*problem.start[key].p, problem.start[key].angle]) for key in problem.poses}
        x.update({key: np.array(problem.start[key].value) for key in problem.points})
        whole, kept = ceres.Problem(), []
        for (a, b, z, _), root in zip(problem.edges, self.roots):
            kept.append(Relative(np.array(z), root))
            whole.add_residual_block(kept[-1], None, [x[a], x[b]])
        for a, b, distance, sigma in problem.ranges:
            kept += [Range(distance, sigma), ceres.HuberLoss(2.0)]
            whole.add_residual_block(kept[-2], kept[-1], [x[a], x[b]])
        if problem.is_fixed:
            whole.set_parameter_block_constant(x[problem.held])
        else:
            kept.append(Prior(x[problem.held].copy(), self.roots[0]))
            whole.add_residual_block(kept[-1], None, [x[problem.held]])
        return whole, x, kept

    def run(self, iterations):
        whole, x, _kept = self.make()
        options = self.ceres.SolverOptions()
        options.max_num_iterations = iterations
        options.function_tolerance, options.gradient_tolerance, options.parameter_tolerance = TOLERANCE, 1e-10, 0.0
        options.linear_solver_type = self.ceres.LinearSolverType.SPARSE_NORMAL_CHOLESKY
        options.initial_trust_region_radius = 1e16  # Gauss-Newton while it works, as holdfast's own Ceres back-end
        options.num_threads, options.logging_type = 1, self.ceres.LoggingType.SILENT
        summary = self.ceres.SolverSummary()
        begin = time.perf_counter()
        self.ceres.solve(options, whole, summary)
        return time.perf_counter() - begin, x, summary

    def first_cost(self):
        return self.run(0)[2].initial_cost

    def solve(self):
        seconds, x, summary = self.run(ITERATIONS)
        values = hf.Values(self.problem.start)
        for key in self.problem.poses:
            values.update(key, hf.Pose2(*x[key]))
        for key in self.problem.points:
            values.update(key, hf.Point2(x[key]))
        return seconds, values, summary.num_successful_steps + summary.num_unsuccessful_steps


class G2o:
    name, method = "g2o", "Levenberg"

    def __init__(self, problem):
        import importlib.metadata

        import g2opy

        if problem.ranges:
            raise NotImplementedError("no edge for a range, and none can be made in Python")
        self.g2o, self.problem, self.version = g2opy, problem, importlib.metadata.version("g2opy")
        self.made()

    def made(self):
        """A new optimizer at the start: one that has been run keeps what it ended with."""
        g2o, flat = self.g2o, self.problem.dim == 3
        self.optimizer = g2o.SparseOptimizer()
        block, linear = (g2o.BlockSolverSE2, g2o.LinearSolverEigenSE2) if flat else (g2o.BlockSolverSE3, g2o.LinearSolverEigenSE3)
        self.optimizer.set_algorithm(getattr(g2o, f"OptimizationAlgorithm{self.method}")(block(linear())))
        self.vertices = {}
        for key in self.problem.poses:
            vertex = (g2o.VertexSE2 if flat else g2o.VertexSE3)()
            vertex.set_id(self.problem.id[key])
            vertex.set_estimate_data(self.numbers(self.problem.start[key]))
            vertex.set_fixed(key == self.problem.held)
            self.optimizer.add_vertex(vertex)
            self.vertices[key] = vertex
        for a, b, z, information in self.problem.edges:
            edge = (g2o.EdgeSE2 if flat else g2o.EdgeSE3)()
            edge.set_vertex(0, self.vertices[a])
            edge.set_vertex(1, self.vertices[b])
            edge.set_measurement_data(np.array(z, float))
            edge.set_information(information if flat else self.half_angle(information))
            self.optimizer.add_edge(edge)
        self.stop = g2o.SparseOptimizerTerminateAction()
        self.stop.set_gain_threshold(TOLERANCE)
        self.optimizer.add_post_iteration_action(self.stop)

    @staticmethod
    def half_angle(information):
        """As the file has it: g2o's residual is the vector part of the quaternion."""
        information = information.copy()
        information[3:, :] *= 2
        information[:, 3:] *= 2
        return information

    @staticmethod
    def numbers(pose):
        return np.array([*pose.p, pose.angle]) if isinstance(pose, hf.Pose2) else np.array([*pose.p, *pose.q])

    def first_cost(self):
        self.optimizer.initialize_optimization()
        self.optimizer.compute_active_errors()
        return 0.5 * self.optimizer.chi2()

    def solve(self):
        self.made()
        begin = time.perf_counter()
        self.optimizer.initialize_optimization()
        iterations = self.optimizer.optimize(ITERATIONS)
        seconds = time.perf_counter() - begin
        values = hf.Values(self.problem.start)
        for key, vertex in self.vertices.items():
            numbers = np.array(vertex.get_estimate_data())
            values.update(key, hf.Pose2(*numbers) if len(numbers) == 3 else hf.Pose3(numbers[:3], numbers[3:]))
        return seconds, values, iterations


class G2oGaussNewton(G2o):
    name, method = "g2o, Gauss-Newton", "GaussNewton"


class G2oDogleg(G2o):
    name, method = "g2o, dogleg", "Dogleg"


class Scipy:
    name = "SciPy"

    def __init__(self, problem):
        import scipy

        if problem.dim != 3 or problem.ranges:
            raise NotImplementedError("relative poses in the plane alone: its losses hold for all residuals at once")
        self.problem, self.version = problem, scipy.__version__
        self.free = [key for key in problem.poses if key != problem.held]
        where = {key: 3 * i for i, key in enumerate(self.free)}
        where[problem.held] = 3 * len(self.free)  # behind the variables
        self.a = np.array([where[a] for a, *_ in problem.edges])
        self.b = np.array([where[b] for _, b, *_ in problem.edges])
        self.z = np.array([z for _, _, z, _ in problem.edges])
        roots = np.array([np.linalg.cholesky(information).T for *_, information in problem.edges])
        c, s = np.cos(self.z[:, 2]), np.sin(self.z[:, 2])
        turn = np.zeros((len(c), 3, 3))
        turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, s, -s, c, 1
        self.roots = roots @ turn
        self.tail = self.numbers(problem.held)
        self.x = np.concatenate([self.numbers(key) for key in self.free])

    def numbers(self, key):
        pose = self.problem.start[key]
        return np.array([*pose.p, pose.angle])

    def parts(self, x):
        x = np.concatenate([x, self.tail])
        a = x[self.a[:, None] + np.arange(3)]
        d = x[self.b[:, None] + np.arange(3)] - a
        return np.cos(a[:, 2]), np.sin(a[:, 2]), d

    def residual(self, x):
        c, s, d = self.parts(x)
        e = np.stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], d[:, 2]], 1) - self.z
        e[:, 2] = np.arctan2(np.sin(e[:, 2]), np.cos(e[:, 2]))
        return np.einsum("nij,nj->ni", self.roots, e).ravel()

    def jacobian(self, x):
        from scipy.sparse import coo_matrix

        c, s, d = self.parts(x)
        n = len(c)
        J_a, J_b = np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
        J_b[:, 0, 0], J_b[:, 0, 1], J_b[:, 1, 0], J_b[:, 1, 1], J_b[:, 2, 2] = c, s, -s, c, 1
        J_a -= J_b
        J_a[:, 0, 2], J_a[:, 1, 2] = -s * d[:, 0] + c * d[:, 1], -c * d[:, 0] - s * d[:, 1]
        rows = np.broadcast_to(3 * np.arange(n)[:, None, None] + np.arange(3)[:, None], (n, 3, 3))
        columns = [np.broadcast_to(k[:, None, None] + np.arange(3), (n, 3, 3)) for k in (self.a, self.b)]
        numbers = np.concatenate([(self.roots @ J).ravel() for J in (J_a, J_b)])
        where = np.concatenate([one.ravel() for one in columns])
        all_rows = np.concatenate([rows.ravel()] * 2)
        free = where < len(x)
        return coo_matrix((numbers[free], (all_rows[free], where[free])), shape=(3 * n, len(x))).tocsr()

    def first_cost(self):
        return 0.5 * float(np.sum(self.residual(self.x) ** 2))

    def solve(self):
        from scipy.optimize import least_squares

        begin = time.perf_counter()
        found = least_squares(self.residual, self.x, self.jacobian, method="trf", tr_solver="lsmr", ftol=TOLERANCE, xtol=None, gtol=1e-10,
                              x_scale="jac", max_nfev=ITERATIONS)
        seconds = time.perf_counter() - begin
        values = hf.Values(self.problem.start)
        for i, key in enumerate(self.free):
            values.update(key, hf.Pose2(*found.x[3 * i:3 * i + 3]))
        return seconds, values, found.nfev


def measure(peers, problem, runs):
    """A line a library; they run in turn."""
    ready, lines = [], []
    small = two_poses(problem)
    for peer in peers:
        name = problem.path.rsplit("/", 1)[-1]
        line = {"suite": "peers", "problem": name, "method": peer.name, "start_cost": problem.score(problem.start)}
        lines.append(line)
        try:
            one = peer(problem)
            line.update(version=one.version, first_cost=one.first_cost())
            overhead = peer(small)
            line["overhead"] = statistics.median(overhead.solve()[0] for _ in range(runs))
            ready.append((one, line))
        except (ImportError, NotImplementedError) as why:
            line["left_out"] = str(why)
    seconds = {peer.name: [] for peer in peers}
    for run in range(runs):
        for one, line in ready:
            if "why" in line or (run > 0 and seconds[one.name][0] > 20):
                continue
            try:
                took, values, iterations = one.solve()
                seconds[one.name].append(took)
                line.update(cost=problem.score(values), iterations=int(iterations))
            except RuntimeError as why:  # GTSAM: an indeterminate system
                line["why"] = str(why)[:200]
    for one, line in ready:
        if seconds[one.name]:
            line["seconds"] = statistics.median(seconds[one.name])
        if abs(line["first_cost"] - line["start_cost"]) > 1e-6 * line["start_cost"]:
            line["other_cost"] = line["first_cost"] / line["start_cost"] - 1
    return lines


PEERS = [Holdfast, Gtsam, GtsamGaussNewton, GtsamDogleg, Pyceres, G2o, G2oGaussNewton, G2oDogleg, Scipy]

def table(lines):
    """The ratios in Markdown."""
    titles, rows = peers_table(lines)
    return "\n".join(["| " + " | ".join(titles) + " |", "|---" * len(titles) + "|", *("| " + " | ".join(row) + " |" for row in rows)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    all_lines = []
    for path in arguments.files:
        for line in measure(PEERS, Problem(path), arguments.runs):
            print(json.dumps(line), flush=True)
            all_lines.append(line)
            if "seconds" in line:
                print(f"{line['problem']:18} {line['method']:18} {line['seconds']:9.4f} s  cost {line['cost']:.6g}", file=sys.stderr)
    print(f"\nSeconds over those of {Holdfast.name}, the fastest method of each library that ends at the best cost (no: none does)\n\n"
          f"{table(all_lines)}", file=sys.stderr)


if __name__ == "__main__":
    main()
