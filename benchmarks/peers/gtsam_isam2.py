#!/usr/bin/env python3
"""GTSAM's iSAM2 step by step, as `holdfast bench incremental` goes: a pose with its edges and ranges a step.

    pip install gtsam numpy
    benchmarks/peers/gtsam_isam2.py shared/data/pose_graph/M3500.g2o shared/data/range/plaza2.pyfg ...

g2o files with poses in the plane or in space; PyFG files with poses, landmarks and ranges between them. A new pose begins where odometry
leads from the newest estimate; a landmark where the file has it, with a prior of 100 m, at its first range.

Time is that of ISAM2.update and of the estimate of the newest pose; factors are made before. `--relinearize` and `--skip` are iSAM2's own
thresholds (its defaults: 0.1 and 10; skip 1 relinearises at every step). Prints a line of JSON a file: mean, p99 and worst microseconds a
step, the total, and the cost at the end (half the squared, whitened residuals) beside that of a batch solve from there.
`--time-limit`: seconds of a file, after which the means of the steps so far are printed.
"""

import argparse
import json
import time

import gtsam
import numpy as np

FAR_AWAY = 100.0  # [m] of a landmark's prior


def symmetric(numbers, size):
    """A matrix from its upper triangle by rows."""
    matrix = np.zeros((size, size))
    matrix[np.triu_indices(size)] = numbers
    return matrix + np.triu(matrix, 1).T


def rotation_first(matrix):
    """From position, rotation to GTSAM's order in space."""
    order = [3, 4, 5, 0, 1, 2]
    return matrix[np.ix_(order, order)]


def pose2(numbers):
    return gtsam.Pose2(*numbers)


def pose3(numbers):
    x, y, z, qx, qy, qz, qw = numbers
    return gtsam.Pose3(gtsam.Rot3.Quaternion(qw, qx, qy, qz), gtsam.Point3(x, y, z))


class Stream:
    """What comes at each step: the key of a pose, and factors that tie nothing newer."""

    def __init__(self, path):
        self.space = 2
        self.poses, self.landmarks, self.edges, self.ranges = {}, {}, [], []
        is_pyfg = path.endswith(".pyfg")
        with open(path, encoding="utf-8") as file:
            for line in file:
                words = line.split()
                if words and not words[0].startswith("#"):
                    self._take(words, is_pyfg)

    @staticmethod
    def _key(word):
        return gtsam.symbol(word[0], int(word[1:])) if word[0].isalpha() else gtsam.symbol("x", int(word))

    def _take(self, words, is_pyfg):
        tag = words[0]
        if is_pyfg and tag not in ("VERTEX_XY", "VERTEX_XYZ"):
            words = words[1:]  # its time
        if tag in ("VERTEX_SE2", "VERTEX_SE3:QUAT"):
            self.space = 2 if tag == "VERTEX_SE2" else 3
            make = pose2 if self.space == 2 else pose3
            self.poses[self._key(words[1])] = make([float(w) for w in words[2:]])
        elif tag in ("VERTEX_XY", "VERTEX_XYZ"):
            self.landmarks[self._key(words[1])] = np.array([float(w) for w in words[2:]])
        elif tag in ("EDGE_SE2", "EDGE_SE3:QUAT"):
            numbers = [float(w) for w in words[3:]]
            measured, noise = (pose2(numbers[:3]), symmetric(numbers[3:], 3)) if tag == "EDGE_SE2" else (
                pose3(numbers[:7]), rotation_first(symmetric(numbers[7:], 6)))
            gaussian = gtsam.noiseModel.Gaussian
            model = gaussian.Covariance(noise) if is_pyfg else gaussian.Information(noise)
            self.edges.append((self._key(words[1]), self._key(words[2]), measured, model))
        elif tag == "EDGE_RANGE":
            self.ranges.append((self._key(words[1]), self._key(words[2]), float(words[3]), float(words[4]) ** 0.5))
        elif not tag.startswith("VERTEX"):
            raise SystemExit(f"{tag} is not read")

    def steps(self):
        """Key, edges, ranges."""
        poses = sorted(self.poses)
        at = {key: ([], []) for key in poses}
        for edge in self.edges:
            at[max(edge[0], edge[1])][0].append(edge)
        for one in self.ranges:
            at[one[0] if one[0] in self.poses else one[1]][1].append(one)
        return [(key, *at[key]) for key in poses]


def run(path, relinearize, skip, time_limit):
    stream = Stream(path)
    in_plane = stream.space == 2
    between = gtsam.BetweenFactorPose2 if in_plane else gtsam.BetweenFactorPose3
    range_ = gtsam.RangeFactor2D if in_plane else gtsam.RangeFactor3D
    prior_on_pose = gtsam.PriorFactorPose2 if in_plane else gtsam.PriorFactorPose3
    prior_on_point = gtsam.PriorFactorPoint2 if in_plane else gtsam.PriorFactorPoint3
    sigma = gtsam.noiseModel.Isotropic.Sigma
    parameters = gtsam.ISAM2Params()
    parameters.setRelinearizeThreshold(relinearize)
    parameters.relinearizeSkip = skip
    parameters.setFactorization("QR")  # its Cholesky calls some of these graphs indeterminate
    isam = gtsam.ISAM2(parameters)
    newest = isam.calculateEstimatePose2 if in_plane else isam.calculateEstimatePose3
    whole = gtsam.NonlinearFactorGraph()
    microseconds, seen = [], set()
    begin_all = time.perf_counter()
    for n, (key, edges, ranges) in enumerate(stream.steps()):
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        start = stream.poses[key]
        if n == 0:
            graph.add(prior_on_pose(key, start, sigma(3 if in_plane else 6, 1e-3)))
        for i, j, measured, model in edges:
            graph.add(between(i, j, measured, model))
            other = i if j == key else j
            if abs(other - key) == 1 and other < key:
                start = newest(other).compose(measured if i == other else measured.inverse())
        for i, j, distance, deviation in ranges:
            landmark = j if j in stream.landmarks else i
            if landmark in stream.landmarks and landmark not in seen:
                seen.add(landmark)
                values.insert(landmark, stream.landmarks[landmark])
                graph.add(prior_on_point(landmark, stream.landmarks[landmark], sigma(stream.space, FAR_AWAY)))
            graph.add(range_(i, j, distance, sigma(1, deviation)))
        values.insert(key, start)
        whole.push_back(graph)
        begin = time.perf_counter()
        isam.update(graph, values)
        newest(key)
        microseconds.append(1e6 * (time.perf_counter() - begin))
        if time.perf_counter() - begin_all > time_limit:
            break
    estimate = isam.calculateEstimate()
    best = gtsam.LevenbergMarquardtOptimizer(whole, estimate).optimize()
    return {"file": path, "backend": "gtsam-isam2", "version": "4.3", "relinearize": relinearize, "skip": skip, "steps": len(microseconds),
            "mean_us": float(np.mean(microseconds)), "p99_us": float(np.percentile(microseconds, 99)),
            "worst_us": float(np.max(microseconds)), "seconds": float(np.sum(microseconds) / 1e6),
            "cost": whole.error(estimate), "batch_cost": whole.error(best)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--relinearize", type=float, default=0.1)
    parser.add_argument("--skip", type=int, default=10)
    parser.add_argument("--time-limit", type=float, default=float("inf"))
    arguments = parser.parse_args()
    for path in arguments.files:
        print(json.dumps(run(path, arguments.relinearize, arguments.skip, arguments.time_limit)), flush=True)


if __name__ == "__main__":
    main()
