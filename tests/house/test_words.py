"""README, docs, CONTRIBUTING and CHANGELOG say what is there.

Links lead somewhere, named files exist, the code shown is that of the example it names, README stays short, every file has the same
version, and CHANGELOG's table of include paths is true.
"""
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
README_WORDS = 700
OUR_FILE = re.compile(r"(?<![\w/.])((?:graph|factors|solvers|adapters|common|program|benchmarks|tests|examples|docs|cmake)/[\w./-]+"
                      r"\.(?:hpp|cpp|md|svg|py|cmake)|scripts/[\w-]+)")
EXAMPLE_NAMES = ("my_", "PART")  # files that CONTRIBUTING makes up


def pages():
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


def without_code(text):
    return re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)


def anchors(text):
    """As GitHub makes them of headings."""
    found = set()
    for heading in re.findall(r"^#+ +(.*?) *$", without_code(text), re.M):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        found.add(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return found


def broken_links(path, text, root):
    findings = []
    for target in re.findall(r"\]\(([^)\s]+)\)", without_code(text)):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, anchor = target.partition("#")
        there = path.parent / file
        if file and (not there.exists() or root not in there.resolve().parents):
            findings.append(f"{path.relative_to(root)}: the link {target} leads nowhere")
        elif anchor and anchor not in anchors(there.read_text(encoding="utf-8") if file else text):
            findings.append(f"{path.relative_to(root)}: the link {target} names a heading that is not there")
    return findings


def missing_files(path, text, root):
    return [f"{path.relative_to(root)}: there is no {file}" for file in OUR_FILE.findall(text)
            if not (root / file).exists() and not any(name in file for name in EXAMPLE_NAMES)]


def false_code(path, text, root):
    """<!-- code of FILE --> before a code block: its pieces (between lines that are …) are in the file, in order, line by line."""
    findings = []
    for file, block in re.findall(r"<!-- code of (\S+) -->\n```\w*\n(.*?)^```", text, re.M | re.S):
        left = (root / file).read_text(encoding="utf-8")
        for piece in re.split(r"^…\n", block, flags=re.M):
            where = left.find(piece)
            if where < 0:
                findings.append(f"{path.relative_to(root)}: this is not code of {file}, or not in this order:\n{piece}")
            else:
                left = left[where + len(piece):]
    return findings


def versions(root):
    """{file: version}"""
    read = lambda file, pattern: re.search(pattern, (root / file).read_text(encoding="utf-8"))[1]
    return {"CMakeLists.txt": read("CMakeLists.txt", r"project\(holdfast VERSION ([\d.]+)"),
            "package.xml": read("package.xml", r"<version>([\d.]+)</version>"),
            "CITATION.cff": read("CITATION.cff", r"(?m)^version: ([\d.]+)$"),
            "CHANGELOG.md": read("CHANGELOG.md", r"(?m)^## (?:Unreleased \()?([\d.]+)"),
            "README.md": read("README.md", r"find_package\(holdfast ([\d.]+)")}


class Words(unittest.TestCase):
    def none(self, findings):
        if findings:
            self.fail("\n" + "\n".join(findings))

    def of_all_pages(self, rule):
        self.assertGreater(len(pages()), 5)
        return [finding for path in pages() for finding in rule(path, path.read_text(encoding="utf-8"), ROOT)]

    def test_links_lead_somewhere(self):
        self.none(self.of_all_pages(broken_links))

    def test_named_files_are_there(self):
        old = lambda path: path.name == "CHANGELOG.md"
        self.none([finding for path in pages() if not old(path) for finding in missing_files(path, path.read_text(encoding="utf-8"), ROOT)])

    def test_shown_code_is_that_of_the_examples(self):
        self.none(self.of_all_pages(false_code))
        self.assertIn("<!-- code of examples/", (ROOT / "README.md").read_text(encoding="utf-8"))

    def test_readme_is_short(self):
        words = len((ROOT / "README.md").read_text(encoding="utf-8").split())
        self.assertLessEqual(words, README_WORDS)

    def test_every_file_has_the_same_version(self):
        found = versions(ROOT)
        version = found["CMakeLists.txt"]
        self.none([f"{file}: version {other}, but CMakeLists.txt has {version}" for file, other in found.items()
                   if other not in (version, version.rpartition(".")[0])])

    def test_the_table_of_include_paths_is_true(self):
        rows = re.findall(r"^\| `([\w/.]+\.hpp)` \| `([\w/.]+\.hpp)` \|$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
        self.assertGreater(len(rows), 30)
        self.none([f"CHANGELOG.md: there is no {new}" for _, new in rows if not (ROOT / new).exists()] +
                  [f"CHANGELOG.md: {old} has not moved" for old, _ in rows if (ROOT / old).exists()])

    def test_no_header_of_the_last_release_is_forgotten(self):
        """Each header of 0.1.0 that is gone from its place is in CHANGELOG."""
        try:
            old = subprocess.run(["git", "ls-tree", "-r", "--name-only", "c90db36"], cwd=ROOT, capture_output=True, text=True,
                                 check=True).stdout.splitlines()
        except (OSError, subprocess.CalledProcessError):
            self.skipTest("the commit of 0.1.0 is not here")
        text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
        self.none([f"CHANGELOG.md: {path} of 0.1.0 is gone, and it does not say where to" for path in old
                   if re.match(r"(graph|factors|solvers|adapters)/\w+\.hpp$", path)
                   and not (ROOT / path).exists() and f"`{path}`" not in text])


class Rules(unittest.TestCase):
    """Each rule broken once."""

    PAGE = ROOT / "page.md"

    def test_a_broken_link(self):
        text = "# A heading, with `code`\n[a](README.md) [b](#a-heading-with-code) [c](https://example.org) ![d](docs/growth.svg)\n"
        self.assertEqual(broken_links(self.PAGE, text, ROOT), [])
        self.assertEqual(broken_links(self.PAGE, "[a](nowhere.md)", ROOT), ["page.md: the link nowhere.md leads nowhere"])
        self.assertIn("a heading that is not there", broken_links(self.PAGE, "# One\n[a](#two)", ROOT)[0])
        self.assertIn("a heading that is not there", broken_links(self.PAGE, "[a](README.md#two)", ROOT)[0])

    def test_a_missing_file(self):
        self.assertEqual(missing_files(self.PAGE, "`graph/graph.hpp`", ROOT), [])
        self.assertEqual(missing_files(self.PAGE, "`graph/nothing.hpp`", ROOT), ["page.md: there is no graph/nothing.hpp"])

    def test_code_that_is_not_the_examples(self):
        page = ("<!-- code of examples/01_agent_ranges.cpp -->\n```cpp\n  Graph graph;\n  Values values;\n…\n"
                "    if (k == 0) continue;\n```\n")
        self.assertEqual(false_code(self.PAGE, page, ROOT), [])
        self.assertIn("not code of examples/01", false_code(self.PAGE, page.replace("k == 0", "k == 1"), ROOT)[0])
        lines = page.split("\n")
        lines[2], lines[5] = lines[5], lines[2]
        self.assertIn("not in this order", false_code(self.PAGE, "\n".join(lines), ROOT)[0])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
