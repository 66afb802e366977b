"""Puts together what Sphinx reads: sources.py OUT.

The pages of docs/ and of the root, with links to files of the tree led to a page that shows the file; consecutive blocks of C++ and Python
side by side; the notebooks; and the pages of docs/site, where <!-- factors: … --> becomes what the headers' comments say, with the figure
of each and the code it is drawn from (factor_figures.py).
"""
import json
import os
import pathlib
import posixpath
import re
import shutil
import sys

import factor_figures

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROOT_PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
CODE = re.compile(r"(^```.*?^```$)", re.M | re.S)
PAIR = re.compile(r"(```cpp\n(?:(?!```).)*?```)\n+(```python\n.*?```)", re.S)
LANGUAGES = {".hpp": "cpp", ".cpp": "cpp", ".py": "python", ".cmake": "cmake", ".json": "json"}


def pages(root=ROOT):
    """{file of the tree: page of the site}"""
    found = {f"docs/{path.name}": path.name for path in sorted((root / "docs").glob("*.md"))}
    found.update({f"docs/notebooks/{path.name}": f"notebooks/{path.name}" for path in sorted((root / "docs/notebooks").glob("*.ipynb"))})
    site = root / "docs" / "site"
    found.update({str(path.relative_to(root)): str(path.relative_to(site)) for path in sorted(site.rglob("*.md"))})
    return {**found, **{name: name for name in ROOT_PAGES}}


def page_of(target, root):
    """Where the site shows a file of the tree; None for a folder."""
    known = pages(root)
    if target in known:
        return known[target]
    if target.startswith("docs/") and target.endswith(".svg"):
        return posixpath.basename(target)
    return f"source/{target}.md" if (root / target).is_file() else None


def with_links(text, file, page, root, shown):
    """Links of a file of the tree as they are on its page; the files that they show are added to `shown`."""
    def replaced(match):
        image, words, target = match.groups()
        place, _, anchor = target.partition("#")
        if not place or re.match(r"[a-z]+:", target):
            return match[0]
        there = posixpath.normpath(posixpath.join(posixpath.dirname(file), place))
        if file.startswith("docs/site/"):  # these link by their places on the site
            there = {on_site: source for source, on_site in pages(root).items()}.get(
                posixpath.normpath(posixpath.join(posixpath.dirname(page), place)), there)
        to = page_of(there, root)
        if to is None:
            return words
        if to.startswith("source/"):
            shown.add(there)
        where = posixpath.relpath(to, posixpath.dirname(page) or ".")
        return f"{image}[{words}]({where}{'#' + anchor if anchor else ''})"
    return "".join(part if part.startswith("```") else LINK.sub(replaced, part) for part in CODE.split(text))


def notebook(text, file, page, root, shown):
    """A notebook with the links of its prose as they are on its page. Sphinx runs it (myst-nb), and shows what it prints."""
    content = json.loads(text)
    for cell in content["cells"]:
        if cell["cell_type"] == "markdown":
            cell["source"] = with_links("".join(cell["source"]), file, page, root, shown)
    return json.dumps(content)


def prose(page, text):
    """What a page says, without the code of a notebook."""
    if not page.endswith(".ipynb"):
        return text
    return "\n\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown")


def side_by_side(text):
    """A block of C++ and the block of Python right after it."""
    return PAIR.sub(r":::::{container} pair\n::::{container} cpp\n\1\n::::\n::::{container} python\n\2\n::::\n:::::", text)


def comment_on_top(header):
    """What the header says before #pragma once, without its slashes."""
    return "\n".join(line[2:].removeprefix(" ") for line in header.split("#pragma once")[0].splitlines() if line.startswith("//"))


def factors_of(header):
    """[(name, [(type, field, what it is)])] of the structs that are factors (they have variables and residuals)."""
    found = []
    for name, body in re.findall(r"^(?:template <[^\n]*>\n)?struct (\w+)[^\n]*\{\n(.*?)^\};", header, re.M | re.S):
        if "using Variables" in body:
            fields = re.findall(r"^  ([\w:<>, ]+?) (\w+)(?: = [^;]+)?;\s+///< ([^\n]*(?:\n +///< [^\n]*)*)", body, re.M)
            found.append((name, [(kind, field, re.sub(r"\s*\n\s*///<", "", what)) for kind, field, what in fields]))
    return found


def uses(name, root):
    """(example, its first line that makes such a factor), of every example."""
    found = []
    for path in sorted((root / "examples").glob("*.cpp")):
        line = re.search(rf"^.*\b{name}(?:<[\w, ]+>)?(?:\{{|::from_).*$", path.read_text(encoding="utf-8"), re.M)
        if line:
            found.append((f"examples/{path.name}", line[0].strip()))
    return found


def section(stem, root, shown):
    """A header of factors/: its comment (formula, units, source), the fields of its factors, and lines of examples that use them."""
    path = f"factors/{stem}.hpp"
    header = (root / path).read_text(encoding="utf-8")
    shown.add(path)
    lines = [f"## {stem}", "", f"[{path}](../source/{path}.md)", "", "```text", comment_on_top(header), "```", ""]
    if stem in factor_figures.FACTORS:
        lines += [f"![{factor_figures.words(stem)}]({stem}.svg)", "", "```python", factor_figures.code(stem), "```", ""]
    for name, fields in factors_of(header):
        lines += [f"### {name}", "", "| field | type | |", "|---|---|---|"]
        lines += [f"| `{field}` | `{kind}` | {what.replace('|', '&#124;')} |" for kind, field, what in fields]
        lines.append("")
        for example, line in uses(name, root):
            shown.add(example)
            lines += [f"From [{example}](../source/{example}.md):", "", "```cpp", line, "```", ""]
    return "\n".join(lines)


def assemble(out, root=ROOT):
    """{page: its text}, written to `out` with the drawings and what Sphinx is told."""
    shown, texts = set(), {}
    for file, page in pages(root).items():
        text = (root / file).read_text(encoding="utf-8")
        if page.endswith(".ipynb"):
            texts[page] = notebook(text, file, page, root, shown)
            continue
        text = with_links(text, file, page, root, shown)
        texts[page] = side_by_side(re.sub(
            r"<!-- factors: ([\w ]+) -->", lambda match: "\n".join(section(stem, root, shown) for stem in match[1].split()), text))
    for path in shown:
        language = LANGUAGES.get(pathlib.Path(path).suffix, "text")
        up = os.path.relpath(root / path, (out / "source" / path).parent)
        texts[f"source/{path}.md"] = f"---\norphan: true\n---\n# {path}\n\n```{{literalinclude}} {up}\n:language: {language}\n```\n"
    for page, text in texts.items():
        (out / page).parent.mkdir(parents=True, exist_ok=True)
        (out / page).write_text(text, encoding="utf-8")
    for path in [*(root / "docs").glob("*.svg"), root / "docs/site/theme.css"]:
        shutil.copy(path, out)
    shutil.copytree(root / "docs/factors", out / "factors", dirs_exist_ok=True)
    return texts


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    print(len(assemble(folder)), "pages")
