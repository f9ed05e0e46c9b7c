#!/usr/bin/env python3
"""Every command of docs/recipes.md, run as it stands, and the pictures there.

    pip install OpenEXR numpy pillow
    tools/recipes.py --gnomon target/release/gnomon --output out/recipes

Blocks are run in their order in the output folder, those of Python by this interpreter. Each must succeed, and each picture of the page must have
been made. With --write the page's pictures are replaced: JPEG of 40 kB at most.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

MOST_BYTES = 40_000
PAGE = Path(__file__).resolve().parent.parent / "docs" / "recipes.md"


def blocks(text):
    """Indented lines that follow each other; a JSON object is something to be read."""
    for block in re.findall(r"(?:^ {4}.*\n|^\n(?= {4}))+", text, re.M):
        lines = [line[4:] for line in block.strip("\n").splitlines()]
        if not lines[0].startswith("{"):
            yield "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gnomon", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--write", action="store_true", help="replace the pictures of the page")
    arguments = parser.parse_args()
    folder = arguments.output.resolve()
    (folder / "bin").mkdir(parents=True, exist_ok=True)
    program = folder / "bin" / "gnomon"
    program.unlink(missing_ok=True)
    program.symlink_to(arguments.gnomon.resolve())
    environment = {**os.environ, "PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}"}
    text = PAGE.read_text()
    holds, count = True, 0
    for block in blocks(text):
        command = [sys.executable, "-c", block] if block.startswith("import") else ["bash", "-e", "-c", block]
        run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        count += 1
        if run.returncode:
            holds = False
            print(f"failed:\n{block}\n{run.stderr}")
    from PIL import Image

    for name in re.findall(r"\]\(recipes/(\w+)\.jpg\)", text):
        made = folder / f"{name}.png"
        if not made.exists():
            holds = False
            print(f"{name}.png was not made")
        elif arguments.write:
            picture = Image.open(made).convert("RGB")
            picture.thumbnail((640, 320))
            path = PAGE.parent / "recipes" / f"{name}.jpg"
            path.parent.mkdir(exist_ok=True)
            picture.save(path, quality=80)
            assert path.stat().st_size <= MOST_BYTES, path
    print(f"{count} blocks of commands {'run' if holds else 'were tried'}")
    sys.exit(0 if holds else 1)


if __name__ == "__main__":
    main()
