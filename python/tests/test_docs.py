"""The code of the documentation runs as it stands."""

import re

import numpy as np
from conftest import ROOT


def blocks(path):
    return re.findall(r"```python\n(.*?)```", (ROOT / path).read_text(), re.DOTALL)


def test_the_page_of_the_package_runs(renderer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    found = blocks("docs/python.md")
    assert len(found) == 3
    for block in found:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert (tmp_path / "boxes.png").stat().st_size > 1000
    assert names["batch"].shape == (3, 72, 96, 3)
    assert not np.array_equal(names["turned"], names["radiance"])


def test_readme_s_python_runs(renderer):
    for block in blocks("README.md"):
        exec(compile(block, "README.md", "exec"), {})
