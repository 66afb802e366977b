#!/usr/bin/env python3
"""GTSAM's iSAM2 on pose graphs in the plane, step by step, as `holdfast bench incremental` goes: a pose with its edges a step.

    pip install gtsam numpy
    benchmarks/peers/gtsam_isam2.py shared/data/pose_graph/M3500.g2o ...

Time is that of ISAM2.update and of the estimate of the newest pose; factors are made before. `--relinearize` and `--skip` are iSAM2's own
thresholds (its defaults: 0.1 and 10; skip 1 relinearises at every step). Prints a line of JSON a file: mean, p99 and worst microseconds a
step, the total, and the cost at the end (half the squared, whitened residuals) beside that of a batch solve from there.
"""

import argparse
import json
import time

import gtsam
import numpy as np


def read(path):
    """Poses' ids and edges (i, j, x, y, theta, information) of a g2o file, edges by the later of their poses."""
    edges, ids = [], set()
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if not words:
                continue
            if words[0] == "VERTEX_SE2":
                ids.add(int(words[1]))
            if words[0] == "EDGE_SE2":
                i, j = int(words[1]), int(words[2])
                ids.update((i, j))
                x, y, t, a, b, c, d, e, f = map(float, words[3:12])
                edges.append((i, j, gtsam.Pose2(x, y, t), np.array([[a, b, c], [b, d, e], [c, e, f]])))
    return sorted(ids), edges


def run(path, relinearize, skip):
    ids, edges = read(path)
    at = {k: [] for k in ids}
    for edge in edges:
        at[max(edge[0], edge[1])].append(edge)
    parameters = gtsam.ISAM2Params()
    parameters.setRelinearizeThreshold(relinearize)
    parameters.relinearizeSkip = skip
    parameters.setFactorization("QR")  # its Cholesky calls some of these graphs indeterminate
    isam = gtsam.ISAM2(parameters)
    whole = gtsam.NonlinearFactorGraph()
    microseconds = []
    for n, k in enumerate(ids):
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        start = gtsam.Pose2()
        if n == 0:
            graph.add(gtsam.PriorFactorPose2(k, start, gtsam.noiseModel.Isotropic.Sigma(3, 1e-3)))
        for i, j, measured, information in at[k]:
            graph.add(gtsam.BetweenFactorPose2(i, j, measured, gtsam.noiseModel.Gaussian.Information(information)))
            other = i if j == k else j
            if abs(other - k) == 1 and other < k:
                from_ = isam.calculateEstimatePose2(other)
                start = from_.compose(measured if i == other else measured.inverse())
        values.insert(k, start)
        whole.push_back(graph)
        begin = time.perf_counter()
        isam.update(graph, values)
        isam.calculateEstimatePose2(k)
        microseconds.append(1e6 * (time.perf_counter() - begin))
    estimate = isam.calculateEstimate()
    best = gtsam.GaussNewtonOptimizer(whole, estimate).optimize()
    return {"file": path, "backend": "gtsam-isam2", "version": "4.3", "relinearize": relinearize, "skip": skip, "steps": len(ids),
            "mean_us": float(np.mean(microseconds)), "p99_us": float(np.percentile(microseconds, 99)),
            "worst_us": float(np.max(microseconds)), "seconds": float(np.sum(microseconds) / 1e6),
            "cost": whole.error(estimate), "batch_cost": whole.error(best)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--relinearize", type=float, default=0.1)
    parser.add_argument("--skip", type=int, default=10)
    arguments = parser.parse_args()
    for path in arguments.files:
        print(json.dumps(run(path, arguments.relinearize, arguments.skip)), flush=True)


if __name__ == "__main__":
    main()
