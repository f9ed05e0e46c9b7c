"""Fixtures: a renderer, inputs that are drawn fast, and the command to be compared with."""

import os
import shutil
import subprocess
from pathlib import Path

import gnomon
import pytest

ROOT = Path(__file__).resolve().parents[2]
SIZE = (96, 72)
# Few lights and small maps: what is tested is the way of a picture, not its error.
QUICK = {"light_count": 8, "ambient_cells": 8, "shadow_resolution": 64, "sharp_shadow_resolution": 128, "supersample": 1}


def skip(reason):
    print(f"skipped: {reason}")
    pytest.skip(reason)


@pytest.fixture(scope="session")
def renderer():
    try:
        return gnomon.Renderer()
    except gnomon.Error as error:
        skip(str(error))


@pytest.fixture(scope="session")
def room():
    return gnomon.Environment.load("room")


@pytest.fixture()
def boxes():
    return gnomon.Scene.load("three-boxes")


@pytest.fixture(scope="session")
def command():
    """Runs the command `gnomon` with these arguments."""
    program = os.environ.get("GNOMON_COMMAND") or shutil.which("gnomon") or str(ROOT / "target/debug/gnomon")
    if not Path(program).exists():
        skip("the command gnomon is not built")

    def run(*arguments):
        return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=300)

    return run


def flags(options):
    """Keyword arguments as the command's options."""
    return [part for name, value in options.items() for part in (f"--{name.replace('_', '-')}", str(value))]
