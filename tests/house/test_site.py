"""The documentation site (docs/site, scripts/docs): every page of docs/ is on it, every link leads somewhere, every code block is run or
said not to be, every factor is on one page. Sphinx itself, with warnings as errors, is run by scripts/docs.
"""
import pathlib
import posixpath
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "site"))
import sources  # noqa: E402


def listed(index):
    """The pages in the index' tables of contents."""
    trees = re.findall(r"^```{toctree}\n(.*?)^```", index, re.M | re.S)
    return [line for tree in trees for line in tree.split("\n") if line and not line.startswith(":")]


def dead_links(texts, drawings):
    known = {*texts, *drawings}
    return [f"{page}: {target} leads nowhere" for page, text in texts.items()
            for _, _, target in sources.LINK.findall(sources.CODE.sub("", sources.prose(page, text))) if not re.match(r"[a-z]+:|#", target)
            and posixpath.normpath(posixpath.join(posixpath.dirname(page), target.partition("#")[0])) not in known]


def blocks_nobody_runs(name, text, python_tests):
    """Blocks of C++ that name no file they are from, and of Python on a page that no test names. <!-- fragment --> excuses."""
    found = []
    for before, language in re.findall(r"^(.*)\n```(cpp|python)$", text, re.M):
        runs = before.startswith("<!-- code of ") if language == "cpp" else name in python_tests
        if not runs and before != "<!-- fragment -->":
            found.append(f"{name}: a block of {language} that no test runs, after the line {before!r}; write <!-- code of FILE -->, "
                         "run the page in tests/python, or say <!-- fragment -->")
    return found


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.texts = sources.assemble(pathlib.Path(folder))

    def test_every_page_is_in_the_index_once(self):
        pages = sorted(posixpath.splitext(page)[0] for page in sources.pages().values() if page != "index.md")
        self.assertGreater(len(pages), 15)
        self.assertEqual(sorted(listed((ROOT / "docs/site/index.md").read_text(encoding="utf-8"))), pages)

    def test_no_link_is_dead(self):
        self.assertEqual(dead_links(self.texts, [str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.svg")]), [])

    def test_code_is_run(self):
        tests = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests/python").glob("test_*.py"))
        self.assertEqual([finding for path in sorted((ROOT / "docs").glob("*.md"))
                          for finding in blocks_nobody_runs(path.name, path.read_text(encoding="utf-8"), tests)], [])

    def test_every_factor_is_on_one_page_with_its_fields(self):
        families = [text for page, text in self.texts.items() if page.startswith("factors/")]
        for path in sorted((ROOT / "factors").glob("*.hpp")):
            self.assertEqual(sum(text.count(f"\n## {path.stem}\n") for text in families), 1, path.name)
            factors = sources.factors_of(path.read_text(encoding="utf-8"))
            self.assertEqual(path.stem in sources.factor_figures.FACTORS, bool(factors), f"{path.name}: docs/site/factor_figures.py")
            for name, _ in factors:
                self.assertEqual(sum(text.count(f"\n### {name}\n") for text in families), 1, name)
        ranges = self.texts["factors/distances.md"]
        self.assertIn("r = (‖p_a − p_b‖ − distance) / sigma", ranges)
        self.assertIn("| `distance` | `double` | [m] |", ranges)


class Rules(unittest.TestCase):
    """Each rule broken once."""

    def test_a_dead_link(self):
        texts = {"a.md": "[b](b.md#x) ![c](c.svg) [d](https://example.org)", "b.md": "[a](a.md)", "source/x.md": "[a](../a.md)"}
        self.assertEqual(dead_links(texts, ["c.svg"]), [])
        self.assertEqual(dead_links({"a.md": "[b](b.md)"}, []), ["a.md: b.md leads nowhere"])

    def test_a_block_that_nobody_runs(self):
        self.assertEqual(blocks_nobody_runs("a.md", "<!-- code of x.cpp -->\n```cpp\n```\n\n```python\n```\n", "a.md"), [])
        self.assertEqual(blocks_nobody_runs("a.md", "<!-- fragment -->\n```cpp\n```\n", ""), [])
        self.assertEqual(len(blocks_nobody_runs("a.md", "words\n```cpp\n```\n\n```python\n```\n", "b.md")), 2)

    def test_the_fields_of_a_factor(self):
        header = ("template <class A>\nstruct Near {\n  double distance;  ///< [m]\n  using Variables = variables<A>;\n};\n"
                  "struct Help {\n  int n;  ///< of it\n};\n")
        self.assertEqual(sources.factors_of(header), [("Near", [("double", "distance", "[m]")])])

    def test_cpp_and_python_side_by_side(self):
        pair = sources.side_by_side("```cpp\na\n```\n\n```python\nb\n```\n")
        self.assertEqual(pair.count("{container}"), 3)
        self.assertEqual(sources.side_by_side("```cpp\na\n```\n\nwords\n\n```python\nb\n```\n").count("{container}"), 0)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
