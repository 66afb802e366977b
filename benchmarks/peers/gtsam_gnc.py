#!/usr/bin/env python3
"""GTSAM's GNC-TLS on the problems that `holdfast bench robust --write` leaves, for the same table:

    python3 -m venv gtsam && gtsam/bin/pip install gtsam==4.3.0 numpy      # outside the tree
    holdfast bench robust --runs 10 --write problems                        # X.g2o, X_clean.g2o, X.json each
    gtsam/bin/python benchmarks/peers/gtsam_gnc.py problems >> bench-out/robust.jsonl
    scripts/tables

Same start, the same threshold (a false alarm of alpha), Levenberg-Marquardt within, odometry as known inliers, the first pose held by a
prior of 1e-6. Seconds: setting the thresholds and the solve; holdfast's hold its set-up, too. The g2o files give information of the vector
part of the quaternion (half the angle) and translation first; GTSAM takes the whole angle and rotation first: the reader converts."""
import glob
import json
import math
import os
import sys
import time

import gtsam
import numpy as np


def symmetric(numbers, dim):
    full = np.zeros((dim, dim))
    full[np.triu_indices(dim)] = numbers
    return full + np.triu(full, 1).T


def pose(tag, numbers):
    if tag.endswith("SE2"):
        return gtsam.Pose2(*numbers)
    x, y, z, qx, qy, qz, qw = numbers
    return gtsam.Pose3(gtsam.Rot3.Quaternion(qw, qx, qy, qz), np.array([x, y, z]))


def edge(tag, words):
    i, j = int(words[0]), int(words[1])
    numbers = [float(word) for word in words[2:]]
    if tag == "EDGE_SE2":
        information = symmetric(numbers[3:], 3)
        return i, j, gtsam.BetweenFactorPose2(i, j, pose(tag, numbers[:3]), gtsam.noiseModel.Gaussian.Information(information))
    information = symmetric(numbers[7:], 6)
    information[3:, :] /= 2
    information[:, 3:] /= 2
    order = [3, 4, 5, 0, 1, 2]
    noise = gtsam.noiseModel.Gaussian.Information(information[np.ix_(order, order)])
    return i, j, gtsam.BetweenFactorPose3(i, j, pose(tag, numbers[:7]), noise)


def read(path):
    """Values, and the edges in the order of the file. A line that is neither ends the program: half a problem is no problem."""
    values, edges, fixed = gtsam.Values(), [], set()
    for number, line in enumerate(open(path, encoding="utf-8"), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] in ("VERTEX_SE2", "VERTEX_SE3:QUAT"):
            values.insert(int(words[1]), pose(words[0].replace(":QUAT", ""), [float(word) for word in words[2:]]))
        elif words[0] in ("EDGE_SE2", "EDGE_SE3:QUAT"):
            edges.append(edge(words[0], words[1:]))
        elif words[0] == "FIX":
            fixed.update(int(word) for word in words[1:])
        else:
            sys.exit(f"{path}, line {number}: '{words[0]}' is neither a pose nor a relative pose; write the problems anew")
    return values, edges, fixed


def position(values, key, planar):
    return (values.atPose2(key) if planar else values.atPose3(key)).translation()


def ate(answer, truth, planar):
    """RMSE after the best rigid motion (Umeyama, no scale), as holdfast's position_error."""
    keys = list(truth.keys())
    a = np.array([position(answer, key, planar) for key in keys])
    b = np.array([position(truth, key, planar) for key in keys])
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    signs = np.ones(a.shape[1])
    signs[-1] = np.sign(np.linalg.det(u @ vt))
    return math.sqrt(((a @ (u * signs) @ vt - b) ** 2).sum(axis=1).mean())


def solve(about, path):
    start, edges, fixed = read(path)
    truth, _, _ = read(path[:-len(".g2o")] + "_clean.g2o")
    held = min(fixed) if fixed else min(start.keys())
    graph, known = gtsam.NonlinearFactorGraph(), []
    for i, j, factor in edges:
        if abs(i - j) == 1:
            known.append(graph.size())
        graph.add(factor)
    planar = isinstance(edges[0][2], gtsam.BetweenFactorPose2)
    dim = 3 if planar else 6
    known.append(graph.size())
    sigmas = gtsam.noiseModel.Isotropic.Sigma(dim, 1e-6)
    graph.add(gtsam.PriorFactorPose2(held, start.atPose2(held), sigmas) if planar
              else gtsam.PriorFactorPose3(held, start.atPose3(held), sigmas))
    loops = sorted(set(range(len(edges))) - set(known))
    if len(loops) != about["true_loops"] + about["false_loops"]:
        sys.exit(f"{path}: {len(loops)} loops, where {path[:-4]}.json says {about['true_loops']} + {about['false_loops']}")
    parameters = gtsam.GncLMParams(gtsam.LevenbergMarquardtParams())
    parameters.setLossType(gtsam.GncLossType.TLS)
    parameters.setKnownInliers(known)
    began = time.perf_counter()
    optimizer = gtsam.GncLMOptimizer(graph, start, parameters)
    optimizer.setInlierCostThresholdsAtProbability(1 - about["alpha"])
    answer = optimizer.optimize()
    seconds = time.perf_counter() - began
    weights = optimizer.getWeights()
    true_loops, false_loops = loops[:about["true_loops"]], loops[about["true_loops"]:]
    true_kept = sum(weights[k] >= 0.5 for k in true_loops)
    false_kept = sum(weights[k] >= 0.5 for k in false_loops)
    error = ate(answer, truth, planar)
    return {"seconds": seconds, "termination": "converged", "ate": error, "success": error < 0.1,
            "true_lost": len(true_loops) - int(true_kept), "false_kept": int(false_kept),
            "true_loops": len(true_loops), "false_loops": len(false_loops),
            "precision": true_kept / (true_kept + false_kept) if true_kept + false_kept else None, "recall": true_kept / len(true_loops)}


def main():
    paths = sorted(glob.glob(os.path.join(sys.argv[1], "*.json"))) if len(sys.argv) == 2 else []
    if not paths:
        sys.exit("give the directory of holdfast bench robust --write: " + __doc__)
    for path in paths:
        about = json.load(open(path, encoding="utf-8"))
        line = {"suite": "robust", "method": "GTSAM GNC-TLS", "gtsam": "4.3.0"}
        line.update({name: about[name] for name in ("graph", "kind", "share", "seed", "commit")})
        try:
            line.update(solve(about, path[:-len(".json")] + ".g2o"))
        except RuntimeError as failed:  # GTSAM's exceptions: an indeterminate system
            line.update({"seconds": None, "termination": "failed", "why": str(failed)[:200], "ate": None, "success": False,
                         "precision": None, "recall": None})
        print(json.dumps(line), flush=True)


main()
