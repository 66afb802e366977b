"""The source tree keeps its own rules (rules.py), and each rule sees what it is there for.

  python3 tests/house/test_house.py            all of it, as ctest runs it
  python3 tests/house/test_house.py Tree       this tree alone
"""
import pathlib
import shutil
import subprocess
import sys
import unittest

import rules

ROOT = pathlib.Path(__file__).resolve().parents[2]


def source_files():
    """What git knows and what is new; without git, every file outside build folders."""
    try:
        listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True,
                                text=True, check=True).stdout.splitlines()
    except (OSError, subprocess.CalledProcessError):
        listed = [str(path.relative_to(ROOT)) for path in ROOT.rglob("*") if not {"build", ".git"} & set(path.relative_to(ROOT).parts)]
    return sorted(path for path in listed if (ROOT / path).is_file())


def is_source(path):
    return path.endswith((".hpp", ".cpp", ".py", ".cmake", ".cmake.in", "CMakeLists.txt")) or path.startswith("scripts/")


class Tree(unittest.TestCase):
    """This tree."""

    def test_keeps_every_rule(self):
        tree = {path: (ROOT / path).read_text(encoding="utf-8") for path in source_files() if is_source(path)}
        self.assertGreater(len(tree), 100, "no sources found")
        findings = [finding for rule in rules.RULES for finding in rule(tree)]
        if findings:
            self.fail("\n" + "\n".join(map(str, findings)))

    def test_is_formatted(self):
        if shutil.which("clang-format") is None:
            self.skipTest("clang-format is not installed (Debian: apt install clang-format)")
        sources = [path for path in source_files() if path.endswith((".hpp", ".cpp"))]
        result = subprocess.run(["clang-format", "--dry-run", *sources], cwd=ROOT, capture_output=True, text=True, check=False)
        lines = [line for line in result.stderr.splitlines() if "clang-format-violations" in line]
        if lines:
            self.fail("\n" + "\n".join(lines) + "\n    Cure: clang-format -i " + " ".join(sorted({line.split(":")[0] for line in lines})))


class Rules(unittest.TestCase):
    """Each rule broken once, in a small tree."""

    def expect(self, findings, path, line, words):
        self.assertEqual([(finding.path, finding.line) for finding in findings], [(path, line)], findings)
        self.assertIn(words, findings[0].rule)
        self.assertTrue(findings[0].cure)

    def test_an_arrow_between_folders(self):
        good = {"solvers/a.cpp": "#include <holdfast/graph/graph.hpp>\n"}
        self.assertEqual(rules.forbidden_arrows(good), [])
        bad = {"solvers/a.cpp": "#include <vector>\n#include <holdfast/factors/range.hpp>\n"}
        self.expect(rules.forbidden_arrows(bad), "solvers/a.cpp", 2, "solvers must not include factors/range.hpp")
        self.expect(rules.forbidden_arrows({"program/a.cpp": '#include "tests/samples.hpp"\n'}), "program/a.cpp", 1, "tests/samples.hpp")

    def test_a_cycle_between_headers(self):
        tree = {"graph/a.hpp": "#include <holdfast/graph/b.hpp>\n", "graph/b.hpp": "#include <holdfast/graph/c.hpp>\n", "graph/c.hpp": "\n"}
        self.assertEqual(rules.cycles(tree), [])
        tree["graph/c.hpp"] = "\n#include <holdfast/graph/a.hpp>\n"
        self.expect(rules.cycles(tree), "graph/c.hpp", 2, "graph/a.hpp -> graph/b.hpp -> graph/c.hpp -> graph/a.hpp")

    def test_a_foreign_header_outside_its_place(self):
        for header, good, bad in [("ceres/ceres.h", "solvers/ceres/ceres.cpp", "solvers/gnc.cpp"),
                                  ("gtsam/geometry/Pose2.h", "adapters/gtsam/variable.hpp", "adapters/mrpt/mrpt.hpp"),
                                  ("mrpt/poses/CPose2D.h", "adapters/mrpt/mrpt.hpp", "graph/graph.hpp"),
                                  ("g2o/core/base_vertex.h", "adapters/g2o/variable.hpp", "program/solve.cpp"),
                                  ("glog/logging.h", "common/log.cpp", "program/main.cpp"),
                                  ("mpi.h", "solvers/distributed/mpi.cpp", "solvers/irls/irls.cpp"),
                                  ("petscksp.h", "solvers/distributed/petsc.cpp", "solvers/irls/irls.cpp"),
                                  ("metis.h", "solvers/linear/ordering.cpp", "solvers/linear/symbolic.cpp")]:
            self.assertEqual(rules.foreign_headers({good: f"#include <{header}>\n"}), [])
            self.expect(rules.foreign_headers({bad: f"#include <{header}>\n"}), bad, 1, f"<{header}>")
        self.expect(rules.foreign_headers({"graph/a.cpp": "#include <boost/any.hpp>\n"}), "graph/a.cpp", 1, "no rule knows")

    def test_an_internal_header_where_it_does_not_belong(self):
        line = "#include <holdfast/graph/internal/x.hpp>\n"
        self.assertEqual(rules.internal_headers({"graph/a.cpp": line, "tests/graph/test_x.cpp": line}, {}), [])
        self.expect(rules.internal_headers({"graph/a.hpp": line}, {}), "graph/a.hpp", 1, "installed")
        self.expect(rules.internal_headers({"program/a.cpp": line}, {}), "program/a.cpp", 1, "internal to graph")
        friends = {("program/a.cpp", "graph/internal/x.hpp"): "why"}
        self.assertEqual(rules.internal_headers({"program/a.cpp": line}, friends), [])
        self.expect(rules.internal_headers({}, friends), "tests/house/rules.py", 1, "which it does not")

    def test_an_example_that_shows_what_is_no_api(self):
        tree = {"examples/01.cpp": "#include <holdfast/graph/detail/dual.hpp>\n"}
        self.expect(rules.details_in_examples(tree), "examples/01.cpp", 1, "no API")

    def test_a_factor_that_the_conformance_tests_leave_out(self):
        header = "\ntemplate <class A>\nstruct Near {\n  static constexpr int residual_dim = 1;\n};\nstruct Rows {\n};\n"
        tree = {"factors/near.hpp": header, "tests/factors/test_near.cpp": "HOLDFAST_CONFORMS(Near<Point2>, Near<Pose2>);\n"}
        self.assertEqual(rules.forgotten_factors(tree), [])
        tree["tests/factors/test_near.cpp"] = "// HOLDFAST_CONFORMS(Near<Point2>);\nHOLDFAST_CONFORMS(Nearest<Point2>);\n"
        self.expect(rules.forgotten_factors(tree), "factors/near.hpp", 3, "leave Near out")

    def test_a_long_line(self):
        self.assertEqual(rules.long_lines({"graph/a.hpp": "ä" * 140 + "\n"}), [])
        self.expect(rules.long_lines({"graph/a.hpp": "\n" + "a" * 141 + "\n"}), "graph/a.hpp", 2, "141 characters")

    def test_a_header_without_a_test(self):
        tree = {"graph/a.hpp": "", "graph/internal/b.hpp": "", "graph/detail/c.hpp": "", "adapters/mrpt/d.hpp": ""}
        tests = {"tests/graph/test_a.cpp": "", "tests/adapters/test_mrpt_d.cpp": ""}
        self.assertEqual(rules.missing_tests({**tree, **tests}, {}), [])
        self.expect(rules.missing_tests({**tree, "tests/adapters/test_mrpt_d.cpp": ""}, {}), "graph/a.hpp", 1, "without a test")
        elsewhere = {"graph/a.hpp": "tests/adapters/test_mrpt_d.cpp"}
        self.expect(rules.missing_tests({**tree, **tests}, elsewhere), "graph/a.hpp", 1, "has a test of its own")
        nowhere = {"graph/z.hpp": "tests/graph/test_a.cpp"}
        self.expect(rules.missing_tests({**tree, **tests}, nowhere), "tests/house/rules.py", 1, "graph/z.hpp")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
