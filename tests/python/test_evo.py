"""evo reads our trajectories, and its absolute trajectory error is that of holdfast."""
import math
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import holdfast as hf


def aligned_rmse(a, b):
    """After the best rigid motion (Umeyama without scale): what the program calls ATE."""
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    signs = np.ones(a.shape[1])
    signs[-1] = np.sign(np.linalg.det(u @ vt))
    return math.sqrt(((a @ (u * signs) @ vt - b) ** 2).sum(axis=1).mean())


def trajectory(seed):
    rng, values, times, pose = np.random.default_rng(seed), hf.Values(), {}, hf.Pose3()
    for k in range(200):
        values.insert(f"A{k}", pose)
        times[f"A{k}"] = 100 + 0.1 * k
        pose = pose * hf.Pose3.from_roll_pitch_yaw([1, 0.1, 0.05], *(0.02 * np.random.default_rng(k).standard_normal(3) + [0, 0.005, 0.03]))
        pose = pose.retract(0.05 * rng.standard_normal(6))
    return values, times


def test_evo_ape_gives_our_ate(tmp_path):
    pytest.importorskip("evo", reason="evo is not installed (pip install evo): its ATE was not compared with ours")
    (truth, times), (estimate, _) = trajectory(1), trajectory(2)
    paths = [hf.write_tum(str(tmp_path / name), values, times)[0] for name, values in (("truth", truth), ("estimate", estimate))]
    evo_ape = shutil.which("evo_ape", path=os.path.dirname(sys.executable)) or "evo_ape"
    done = subprocess.run([evo_ape, "tum", *paths, "-a"], capture_output=True, text=True, check=True)
    theirs = next(float(line.split()[1]) for line in done.stdout.splitlines() if line.split()[:1] == ["rmse"])
    places = [np.array([values[key].p for key in values]) for values in (estimate, truth)]
    ours = aligned_rmse(*places)
    assert ours > 0.5 and abs(theirs - ours) < 1e-6
