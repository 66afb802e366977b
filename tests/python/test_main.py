"""`python -m holdfast`: the program where there is one, and files without it."""
import os
import shutil
import subprocess
import sys

import pytest

from holdfast.__main__ import program

FILE = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.2 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})


def test_a_file_is_solved(tmp_path):
    path = tmp_path / "two.g2o"
    path.write_text(FILE, encoding="utf-8")
    done = run(sys.executable, "-m", "holdfast", str(path))
    assert done.returncode == 0 and "2 variables, 1 factors: converged" in done.stdout
    path.write_text("VERTEX_SE2 0 0 0\n", encoding="utf-8")
    done = run(sys.executable, "-m", "holdfast", str(path))
    assert done.returncode == 1 and "two.g2o, line 1" in done.stderr


def test_everything_else_is_the_program():
    if program() is None:
        pytest.skip("this build has no program `holdfast` beside the module (target holdfast_cli)")
    for arguments in (["--help"], ["solve", "--help"], ["no-such-command"]):
        ours, theirs = run(sys.executable, "-m", "holdfast", *arguments), run(program(), *arguments)
        assert (ours.returncode, ours.stdout, ours.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr)


@pytest.mark.parametrize("shell,check", [("bash", "-n"), ("zsh", "-n"), ("fish", "--no-execute")])
def test_the_completion_is_a_script_of_its_shell(tmp_path, shell, check):
    if program() is None:
        pytest.skip("this build has no program `holdfast` beside the module (target holdfast_cli)")
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} (Debian: apt install {shell}): its completion was not read by it")
    script = tmp_path / "completion"
    script.write_text(run(program(), "completion", shell).stdout, encoding="utf-8")
    assert script.stat().st_size > 500
    read = run(shell, check, str(script))
    assert read.returncode == 0 and not read.stderr, read.stderr


def test_fish_offers_what_there_is(tmp_path):
    if program() is None or shutil.which("fish") is None:
        pytest.skip("no program beside the module, or no fish (Debian: apt install fish)")
    script = tmp_path / "completion"
    script.write_text(run(program(), "completion", "fish").stdout, encoding="utf-8")
    said = run("fish", "-c", f"source {script}; complete -C 'holdfast solve --sta'; complete -C 'holdfast simu'").stdout
    assert said.split("\t")[0] == "--start" and "simulate\t" in said
