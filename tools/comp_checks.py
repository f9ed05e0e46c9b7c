#!/usr/bin/env python3
"""Pictures without a background of `gnomon render`, laid over a checkerboard by other programs.

    pip install numpy pillow opencv-python-headless OpenImageIO    # OpenImageIO may be left out
    tools/comp_checks.py --gnomon target/release/gnomon --output out/comp

A model on a catcher is written as PNG, whose alpha is straight, and as EXR, whose colours are premultiplied. Pillow lays the PNG over a
checkerboard, in displayed values as pages do; OpenCV's arithmetic lays its premultiplied colours over it; OpenImageIO lays the EXR over the
checkerboard in linear light, and so does the PNG's decoded colours by hand. All must be one picture to 1/255, and none may be what the wrong
kind of alpha makes.
"""

import argparse
import importlib.util
import subprocess
import sys
from pathlib import Path

import cv2
import numpy
from PIL import Image

SIZE = (320, 240)
STEP = 1 / 255 + 1e-6


def decode(srgb):
    return numpy.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def encode(linear):
    linear = numpy.clip(linear, 0, 1)
    return numpy.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def checkerboard():
    y, x = numpy.mgrid[0 : SIZE[1], 0 : SIZE[0]] // 16
    return numpy.where(((x + y) % 2)[..., None] == 0, (153, 153, 153), (102, 102, 102)).astype(numpy.uint8)


def exr_over(path, board, folder):
    """By OpenImageIO, else by the same sum; linear values."""
    import OpenEXR

    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    top = numpy.stack([channels[c].pixels for c in "RGBA"], -1).astype(numpy.float32)
    bottom = numpy.concatenate([decode(board / 255), numpy.ones((*board.shape[:2], 1))], -1).astype(numpy.float32)
    if importlib.util.find_spec("OpenImageIO") is None:
        print("OpenImageIO: skipped, it is not installed")
        return top, top[..., :3] + (1 - top[..., 3:]) * bottom[..., :3]
    import OpenImageIO as oiio

    names = [str(path), str(folder / "board.exr")]
    oiio.ImageBuf(bottom).write(names[1])
    layers = [oiio.ImageBufAlgo.channels(oiio.ImageBuf(name), ("R", "G", "B", "A")) for name in names]
    return top, oiio.ImageBufAlgo.over(*layers).get_pixels(oiio.FLOAT)[..., :3]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gnomon", default="gnomon")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--scene", default="three-boxes")
    parser.add_argument("--env", default="room")
    arguments = parser.parse_args()
    folder = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("comp.png", "comp.exr"):
        # Linear display of what is never too bright, so that both files hold the same numbers.
        look = ["--ground", "catcher", "--background", "transparent", "--tone-mapping", "linear", "--exposure", "-2", "--check", "0"]
        size = ["--size", f"{SIZE[0]}x{SIZE[1]}", "-o", str(folder / name)]
        subprocess.run([arguments.gnomon, "--quiet", "render", arguments.scene, "--env", arguments.env, *look, *size], check=True)
    board = checkerboard()
    png = Image.open(folder / "comp.png")
    assert png.mode == "RGBA", png.mode
    by_pillow = numpy.array(Image.alpha_composite(Image.fromarray(board).convert("RGBA"), png).convert("RGB")) / 255
    Image.fromarray((by_pillow * 255).round().astype(numpy.uint8)).save(folder / "pillow.png")

    straight = cv2.cvtColor(cv2.imread(str(folder / "comp.png"), cv2.IMREAD_UNCHANGED), cv2.COLOR_BGRA2RGBA).astype(numpy.float32) / 255
    alpha = cv2.merge([straight[..., 3]] * 3)
    premultiplied = cv2.multiply(numpy.ascontiguousarray(straight[..., :3]), alpha)
    by_opencv = cv2.add(premultiplied, cv2.multiply(board.astype(numpy.float32) / 255, 1 - alpha))

    top, by_exr = exr_over(folder / "comp.exr", board, folder)
    scaled = top[..., :3] * 2.0**-2
    # The EXR is not exposed, its alpha is: what shows of the board is the same.
    by_exr = by_exr - top[..., :3] + scaled
    by_png = decode(straight[..., :3]) * straight[..., 3:] + (1 - straight[..., 3:]) * decode(board / 255)
    Image.fromarray((encode(by_exr) * 255).round().astype(numpy.uint8)).save(folder / "openimageio.png")

    shadow = ((top[..., 3] > 0.05) & (top[..., 3] < 0.95)).mean()
    wrong = encode(scaled * top[..., 3:] + (1 - top[..., 3:]) * decode(board / 255))
    off = {
        "Pillow (straight) and OpenCV (premultiplied)": abs(by_pillow - by_opencv).max(),
        "PNG (straight) and EXR (premultiplied) in linear light": abs(encode(by_png) - encode(by_exr)).max(),
        "alpha of PNG and EXR": abs(straight[..., 3] - top[..., 3]).max(),
    }
    for what, most in off.items():
        print(f"{what}: off by {255 * most:.2f} / 255 at most")
    print(f"partly covered: {100 * shadow:.1f} % of the pixels; premultiplied colours taken for straight ones would be off by {255 * abs(wrong - encode(by_exr)).max():.0f} / 255")
    sys.exit(0 if max(off.values()) <= STEP and shadow > 0.02 and top[..., :3].max() * 2.0**-2 <= 1 else 1)


if __name__ == "__main__":
    main()
