"""The code of the documentation runs as it stands."""

import os
import re
import shutil

import gnomon
import numpy as np
from conftest import ROOT


def blocks(path):
    return re.findall(r"```python\n(.*?)```", (ROOT / path).read_text(), re.DOTALL)


def test_the_page_of_the_package_runs(renderer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    found = blocks("docs/python.md")
    assert len(found) == 4
    for block in found:
        exec(compile(block, "docs/python.md", "exec"), names)
    made = sorted(path.name for path in tmp_path.glob("*.png"))
    assert made == sorted(re.findall(r"\(python/(.*?)\)", (ROOT / "docs/python.md").read_text()))
    for name in made:
        shown = ROOT / "docs/python" / name
        if os.environ.get("GNOMON_UPDATE_DOCS"):
            shown.parent.mkdir(exist_ok=True)
            shutil.copy(tmp_path / name, shown)
        # Drivers differ by a step of 8 bits here and there.
        assert gnomon.compare(gnomon.read(tmp_path / name), gnomon.read(shown))["relative_rmse"] < 0.01, name
    assert names["batch"].shape == (3, 72, 96, 3)
    assert not np.array_equal(names["turned"], names["radiance"])


def test_readme_s_python_runs(renderer):
    for block in blocks("README.md"):
        exec(compile(block, "README.md", "exec"), {})
