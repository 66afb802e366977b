"""python -m holdfast FILE…: solves the problems of PyFG, g2o, TORO and JRL files, and says how.

With anything but a file it is the C++ program `holdfast` (docs/program.md), where one is built beside the module.
"""
import argparse
import os
import sys

import holdfast as hf


def program():
    """The C++ program of the build folder that the module is in. None: there is none."""
    folder = os.path.dirname(os.path.abspath(hf._core.__file__))
    path = os.path.join(os.path.dirname(os.path.dirname(folder)), "bin", "holdfast")
    return path if os.access(path, os.X_OK) else None


def main():
    path = program()
    if path is not None and not (len(sys.argv) > 1 and os.path.isfile(sys.argv[1])):
        sys.stdout.flush()
        os.execv(path, [path, *sys.argv[1:]])
    return solve_files()


def solve_files():
    parser = argparse.ArgumentParser(prog="python -m holdfast", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--backend", default="irls", help="one of: " + ", ".join(hf.backend_names()) + ", each also as gnc-…")
    parser.add_argument("--loss", default="squared", help="huber:2, cauchy:1, truncated_squares:3, …")
    parser.add_argument("--start", default="file", choices=["file", "odometry", "chordal", "convex"])
    parser.add_argument("--plot", metavar="HTML", help="write the answer of the last file as a page (needs plotly)")
    arguments = parser.parse_args()
    failed = False
    for path in arguments.files:
        try:
            graph, values = hf.read_problem(path, loss=hf.Loss(arguments.loss), start=arguments.start)
            summary = hf.make_backend(arguments.backend, second_order=True).solve(graph, values)
        except hf.Error as error:
            print(f"holdfast: {error}", file=sys.stderr)
            failed = True
            continue
        print(f"{path}: {len(values)} variables, {len(graph)} factors: {summary}")
        for finding in hf.merged(hf.check(graph, values)):
            print(f"holdfast: warning: {finding.text}", file=sys.stderr)
        failed = failed or not summary.usable
        if arguments.plot:
            hf.plot(values, arguments.plot)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
