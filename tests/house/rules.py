"""The rules of the source tree, each a function from a tree {path: text} to a list of findings.

tests/house/test_house.py runs them on this tree and breaks each one once on a small tree of its own. What may include what, where foreign
libraries may be used and which headers need no test of their own is written down here, and only here.
"""
import posixpath
import re
from typing import Dict, List, NamedTuple

Tree = Dict[str, str]


class Finding(NamedTuple):
    path: str
    line: int
    rule: str
    cure: str

    def __str__(self):
        return f"{self.path}:{self.line}: {self.rule}\n    {self.cure}"


class Include(NamedTuple):
    path: str
    line: int
    target: str  # one of ours: its path in this tree; a foreign one: as written
    ours: bool


LIBRARY = {"graph", "factors", "solvers", "adapters"}

# Which folder may include which. Whatever is not listed is forbidden.
ARROWS = {
    "graph": {"graph"},
    "factors": {"graph", "factors"},
    "solvers": {"graph", "solvers"},
    "adapters": LIBRARY,
    "holdfast.hpp": LIBRARY - {"adapters"},
    "common": LIBRARY | {"common"},
    "benchmarks": LIBRARY | {"common", "benchmarks"},
    "benchmarks/micro": LIBRARY | {"common", "benchmarks", "tests"},
    "program": LIBRARY | {"common", "benchmarks", "program"},
    "examples": LIBRARY | {"holdfast.hpp", "examples"},
    "python": LIBRARY | {"common", "python"},
    "tests": LIBRARY | {"holdfast.hpp", "common", "benchmarks", "program", "python", "tests"},
}

# Which foreign headers may be used where: a pattern of the header, patterns of the folders or files.
ANYWHERE_ABOVE = r"(benchmarks/peers|examples|tests)/"
FOREIGN = [
    (r"Eigen/", [r""]),
    (r"(unistd|fcntl|time|immintrin|cxxabi|sys/\w+)\.h$", [r""]),  # the system's and the compiler's
    (r"metis\.h$", [r"solvers/linear/ordering\.cpp$"]),
    (r"(ceres|glog)/", [r"solvers/ceres/", r"adapters/ceres/", ANYWHERE_ABOVE]),
    (r"glog/", [r"common/log\.cpp$"]),
    (r"mrpt/", [r"adapters/mrpt/", ANYWHERE_ABOVE]),
    (r"gtsam/", [r"adapters/gtsam/", ANYWHERE_ABOVE]),
    (r"g2o/", [r"adapters/g2o/", ANYWHERE_ABOVE]),
    (r"(mpi|petsc\w*)\.h$", [r"solvers/distributed/", ANYWHERE_ABOVE]),
    (r"CLI/", [r"program/", r"benchmarks/"]),
    (r"nlohmann/", [r"common/", r"program/", r"benchmarks/", r"tests/"]),
    (r"benchmark/", [r"benchmarks/micro/"]),
    (r"nanobind/", [r"python/"]),
    (r"(gtest|gmock|rapidcheck)\b", [r"tests/"]),
]

# Tests and microbenchmarks look inside; the projects against an install cannot.
MAY_LOOK_INSIDE = r"tests/(?!consumer/|consumer_parts/)|benchmarks/micro/"

# Who else may include an internal header of another folder, and why.
INTERNAL_FRIENDS = {
    ("adapters/ceres/ceres.cpp", "solvers/ceres/internal/cost.hpp"): "both hand our residuals to Ceres, in one library",
    ("adapters/ceres/ceres.cpp", "solvers/ceres/internal/loss.hpp"): "both translate our losses to Ceres, in one library",
    ("adapters/ceres/ceres.cpp", "solvers/ceres/internal/manifold.hpp"): "both hand our manifolds to Ceres, in one library",
    ("adapters/g2o/backend.cpp", "solvers/internal/foreign_backend.hpp"): "a back-end around another library's optimizer",
    ("adapters/gtsam/backend.cpp", "solvers/internal/foreign_backend.hpp"): "a back-end around another library's optimizer",
    ("benchmarks/suites/pose_graph.cpp", "solvers/linear/internal/symbolic.hpp"): "it prints the size of the factorisation",
    ("program/pyfg_lines.cpp", "graph/files/internal/parser.hpp"): "it reads a stream line by line as the reader reads a file",
    ("program/track.cpp", "graph/files/internal/text.hpp"): "numbers are read and written as in files",
}

# Public headers that have no test named after them: where they are tested instead.
TESTED_ELSEWHERE = {
    "adapters/ceres/block_layout.hpp": "tests/adapters/test_ceres.cpp",
    "adapters/files/convert.hpp": "tests/adapters/files/test_cases.cpp",
    "adapters/files/problem.hpp": "tests/adapters/test_round_trip.cpp",
    "adapters/files/range_start.hpp": "tests/benchmarks/test_scenarios.cpp",
    "adapters/files/report.hpp": "tests/adapters/files/test_cases.cpp",
    "adapters/files/to_dataset.hpp": "tests/adapters/test_round_trip.cpp",
    "adapters/files/vertex_value.hpp": "tests/adapters/files/test_edge_to_factor.cpp",
    "adapters/g2o/backend.hpp": "tests/adapters/test_g2o.cpp",
    "adapters/g2o/variable.hpp": "tests/adapters/test_g2o.cpp",
    "adapters/gtsam/backend.hpp": "tests/adapters/test_gtsam.cpp",
    "adapters/gtsam/graph.hpp": "tests/adapters/test_gtsam.cpp",
    "adapters/gtsam/variable.hpp": "tests/adapters/test_gtsam.cpp",
    "adapters/mrpt/graph.hpp": "tests/adapters/test_mrpt.cpp",
    "graph/batch.hpp": "tests/graph/test_graph.cpp",
    "graph/error.hpp": "tests/graph/files/test_errors.cpp",
    "graph/factor.hpp": "tests/factors/test_every_factor.cpp",
    "graph/fields.hpp": "tests/graph/files/test_binary.cpp",
    "graph/files/dataset.hpp": "tests/graph/files/test_formats.cpp",
    "graph/math.hpp": "tests/graph/variables/test_variables.cpp",
    "graph/observability.hpp": "tests/graph/test_check.cpp",
    "graph/require.hpp": "tests/test_backends_measurements.cpp",
    "graph/variables/kinematic.hpp": "tests/graph/variables/test_variables.cpp",
    "graph/variables/pose2.hpp": "tests/graph/variables/test_variables.cpp",
    "graph/variables/pose3.hpp": "tests/graph/variables/test_variables.cpp",
    "graph/variables/so3.hpp": "tests/graph/variables/test_variables.cpp",
    "graph/variables/turning2.hpp": "tests/graph/variables/test_variables.cpp",
    "solvers/distributed/communicator.hpp": "tests/solvers/distributed/test_distributed_graph.cpp",
    "solvers/options.hpp": "tests/solvers/test_backend.cpp",
    "solvers/summary.hpp": "tests/solvers/test_backend.cpp",
}

LONGEST_LINE = 140  # characters


def includes(tree: Tree) -> List[Include]:
    found = []
    for path, text in tree.items():
        if not path.endswith((".hpp", ".cpp")):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
            if match is None:
                continue
            target = match[2]
            if target == "holdfast/testing.hpp":
                target = "tests/testing.hpp"
            elif target.startswith("holdfast/testing/"):
                target = "tests/" + target[len("holdfast/"):]
            elif target.startswith("holdfast/"):
                target = target[len("holdfast/"):]
            if match[1] == '"' and room(target) not in ARROWS:  # beside the file itself
                target = posixpath.normpath(posixpath.join(posixpath.dirname(path), target))
            ours = match[1] == '"' or room(target) in ARROWS
            found.append(Include(path, number, target, ours))
    return found


def room(path: str) -> str:
    return path.split("/")[0]


def is_installed(path: str) -> bool:
    """A header that a user of an installed holdfast can include."""
    if not path.endswith(".hpp") or "/internal/" in path:
        return False
    return room(path) in LIBRARY or path in ("holdfast.hpp", "tests/testing.hpp") or path.startswith("tests/testing/")


def is_public(path: str) -> bool:
    return is_installed(path) and "/detail/" not in path


def forbidden_arrows(tree: Tree) -> List[Finding]:
    findings = []
    for include in includes(tree):
        source = max((place for place in ARROWS if (include.path + "/").startswith(place + "/")), default="")
        target = room(include.target)
        if include.ours and source in ARROWS and target not in ARROWS[source]:
            allowed = ", ".join(sorted(ARROWS[source]))
            findings.append(Finding(include.path, include.line, f"{source} must not include {include.target}",
                                    f"{source} may include: {allowed} (ARROWS in tests/house/rules.py); move what both need below both."))
    return findings


def cycles(tree: Tree) -> List[Finding]:
    edges = {}
    for include in includes(tree):
        if include.path.endswith(".hpp") and include.target in tree:
            edges.setdefault(include.path, []).append(include)
    findings, finished = [], set()

    def visit(path, stack):
        if path in finished:
            return
        for include in edges.get(path, []):
            if include.target in stack:
                loop = stack[stack.index(include.target):] + [include.target]
                findings.append(Finding(include.path, include.line, "headers include each other: " + " -> ".join(loop),
                                        "Declare what is needed instead of including it, or move it to a header of its own."))
            else:
                visit(include.target, stack + [include.target])
        finished.add(path)

    for path in sorted(edges):
        visit(path, [path])
    return findings


def foreign_headers(tree: Tree) -> List[Finding]:
    findings = []
    for include in includes(tree):
        if include.ours or re.fullmatch(r"[a-z_]+", include.target):  # ours or the standard's
            continue
        rules = [places for header, places in FOREIGN if re.match(header, include.target)]
        if not rules:
            findings.append(Finding(include.path, include.line, f"<{include.target}> is a foreign header that no rule knows",
                                    "Say in FOREIGN (tests/house/rules.py) where it may be used; the core needs Eigen alone."))
        elif not any(re.match(place, include.path) for places in rules for place in places):
            where = ", ".join(place.replace("\\", "").rstrip("$") for places in rules for place in places)
            findings.append(Finding(include.path, include.line, f"<{include.target}> is a foreign header outside its place",
                                    f"It may be used in: {where}. Put the code that needs it there."))
    return findings


def internal_headers(tree: Tree, friends=None) -> List[Finding]:
    friends = INTERNAL_FRIENDS if friends is None else friends
    findings, used = [], set()
    for include in includes(tree):
        if not include.ours or "/internal/" not in include.target:
            continue
        pair = (include.path, include.target)
        if is_installed(include.path):
            findings.append(Finding(include.path, include.line, f"an installed header includes {include.target}, which is not installed",
                                    "Include it in the .cpp, or move it to the folder detail/ beside internal/."))
        elif pair in friends:
            used.add(pair)
        elif room(include.path) != room(include.target) and not re.match(MAY_LOOK_INSIDE, include.path):
            findings.append(Finding(include.path, include.line, f"{include.target} is internal to {room(include.target)}",
                                    "Use the public header, or move what is shared to the folder detail/ beside internal/."))
    for path, target in sorted(set(friends) - used):
        findings.append(Finding("tests/house/rules.py", 1, f"INTERNAL_FRIENDS lets {path} include {target}, which it does not",
                                "Take it out of INTERNAL_FRIENDS."))
    return findings


def details_in_examples(tree: Tree) -> List[Finding]:
    return [Finding(include.path, include.line, f"an example includes {include.target}, which is no API",
                    "Show the public header; where there is none, the API lacks something.")
            for include in includes(tree)
            if re.match(r"examples/|tests/consumer(_parts)?/", include.path) and re.search(r"/(detail|internal)/", include.target)]


def forgotten_factors(tree: Tree) -> List[Finding]:
    """Every factor struct must be named in a HOLDFAST_CONFORMS(…) of its header's own test."""
    findings = []
    for path, text in tree.items():
        if not re.fullmatch(r"factors/\w+\.hpp", path):
            continue
        test = "tests/factors/test_" + path[len("factors/"):-len(".hpp")] + ".cpp"
        conforming = " ".join(re.findall(r"^HOLDFAST_CONFORMS\((.*?)\)\s*;?\s*$", tree.get(test, ""), re.M | re.S))
        structs = [(m.start(), m[1]) for m in re.finditer(r"^struct (\w+)[^;{]*\{", text, re.M)]
        for dim in re.finditer(r"^  static constexpr int residual_dim", text, re.M):
            start, name = max(s for s in structs if s[0] < dim.start())
            if not re.search(rf"\b{name}\b", conforming):
                findings.append(Finding(path, text.count("\n", 0, start) + 1, f"the conformance tests leave {name} out",
                                        f"Add HOLDFAST_CONFORMS({name}<…>); to {test}: then it runs in every back-end and host."))
    return findings


def long_lines(tree: Tree) -> List[Finding]:
    findings = []
    for path, text in tree.items():
        if not (path.endswith((".hpp", ".cpp", ".py", ".cmake", ".cmake.in", "CMakeLists.txt")) or path.startswith("scripts/")):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if len(line) > LONGEST_LINE:
                findings.append(Finding(path, number, f"a line of {len(line)} characters; the longest allowed has {LONGEST_LINE}",
                                        "Break it."))
    return findings


def missing_tests(tree: Tree, elsewhere=None) -> List[Finding]:
    elsewhere = TESTED_ELSEWHERE if elsewhere is None else elsewhere
    findings = []
    for path in sorted(tree):
        if not is_public(path) or room(path) not in LIBRARY:
            continue
        folder, _, name = path[:-len(".hpp")].rpartition("/")
        mirrored = rf"tests/({folder}/)?([\w/]+/)?test_(properties_|stress_)?{name}(_\w+)?\.cpp"
        if room(path) == "adapters":  # tests/adapters/test_mrpt_rawlog.cpp tests adapters/mrpt/rawlog.hpp
            part = folder.split("/")[-1]
            mirrored = rf"tests/adapters/([\w/]+/)?test_({part}_)?{name}(_\w+)?\.cpp"
        tested = any(re.fullmatch(mirrored, other) for other in tree)
        if not tested and path not in elsewhere:
            findings.append(Finding(path, 1, "a public header without a test of its own",
                                    f"Write tests/{folder}/test_{name}.cpp, or say in TESTED_ELSEWHERE (tests/house/rules.py) why not."))
        if tested and path in elsewhere:
            findings.append(Finding(path, 1, "it has a test of its own, and TESTED_ELSEWHERE says that it has none",
                                    "Take it out of TESTED_ELSEWHERE (tests/house/rules.py)."))
    for path in sorted(name for entry in elsewhere.items() for name in entry if name not in tree):
        findings.append(Finding("tests/house/rules.py", 1, f"TESTED_ELSEWHERE names {path}, which is not there", "Correct the entry."))
    return findings


RULES = [forbidden_arrows, cycles, foreign_headers, internal_headers, details_in_examples, forgotten_factors, long_lines, missing_tests]
