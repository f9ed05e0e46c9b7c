#!/usr/bin/env python3
"""How much pictures change from frame to frame, beside ray-traced ones: a turntable and a turning sun.

    tools/frame_change.py GNOMON DATA FOLDER

draws 60 frames of 128 x 96 pixels of fence and plaza under spiaggia, turned by 0.48 degrees a frame, by the GPU and by the ray tracer (64 samples a
pixel, the same random numbers in every frame), and prints the 99th percentile of change over the mean, away from edges of surfaces. The tracer's noise,
found with a second seed, is taken out of its own in squares. Needs numpy and OpenEXR.
"""
import pathlib
import subprocess
import sys

import numpy as np
import OpenEXR

FRAMES, SEEDED = 60, 10
# Of a normal distribution, both tails.
DEVIATIONS_OF_PERCENTILE = 2.576
# Neighbours that differ by more, lit without shadows, belong to two surfaces.
EDGE = 0.02


def read(path):
    channels = OpenEXR.File(str(path)).channels()
    for name in ("RGB", "RGBA"):
        if name in channels:
            return np.asarray(channels[name].pixels, np.float64)[..., :3]
    return np.stack([channels[name].pixels for name in "RGB"], -1).astype(np.float64)


def main(gnomon, data, folder):
    data, folder = pathlib.Path(data), pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    spiaggia = str(data / "env/cc0_spiaggia_di_mondello_1k.hdr")

    def sequence(command, name, scene, frames, *options):
        files = folder / f"{name}_####.exr"
        scene = data / f"scenes/{scene}.glb"
        common = ["--ground", "none", "--size", "128x96", "--fps", "25", "--frames", f"0..{frames - 1}", "-q"]
        subprocess.run([gnomon, command, scene, *common, *options, "-o", files], check=True)
        return np.stack([read(folder / f"{name}_{frame:04}.exr") for frame in range(frames)])

    for scene in ("fence", "plaza"):
        for name, turn in (("turntable", "--turntable"), ("turning sun", "--env-turn")):
            file = f"{scene}_{turn.strip('-')}"
            motion = ["--env", spiaggia, turn, "12"]
            drawn = sequence("render", file + "_drawn", scene, FRAMES, *motion).mean(-1)
            traced = sequence("reference", file + "_traced", scene, FRAMES, *motion, "--spp", "64").mean(-1)
            seeded = sequence("reference", file + "_seeded", scene, SEEDED, *motion, "--spp", "64", "--seed", "7").mean(-1)
            kept = np.ones((FRAMES - 1, *drawn.shape[1:]), bool)
            if turn == "--turntable":
                flat = ["--env", "room", turn, "12", "--shadows", "none"]
                surfaces = sequence("render", file + "_flat", scene, FRAMES, *flat)
                edges = np.zeros(surfaces.shape[:3], bool)
                down = np.abs(np.diff(surfaces, axis=1)).max(-1) > EDGE
                right = np.abs(np.diff(surfaces, axis=2)).max(-1) > EDGE
                edges[:, 1:] |= down
                edges[:, :-1] |= down
                edges[:, :, 1:] |= right
                edges[:, :, :-1] |= right
                kept = ~(edges[1:] | edges[:-1])
            change = [np.diff(frames, axis=0) for frames in (drawn, traced, seeded)]
            noise = np.sqrt(((change[1][: SEEDED - 1] - change[2]) ** 2).mean() / 2)
            of_drawn, of_traced = (np.percentile(np.abs(c[kept]), 99) for c in change[:2])
            without_noise = np.sqrt(max(of_traced**2 - (DEVIATIONS_OF_PERCENTILE * noise) ** 2, 0.0))
            mean = traced.mean()
            print(
                f"{scene}, {name}: drawn {of_drawn / mean:.3f}, traced {without_noise / mean:.3f}"
                f" (noise {noise / mean:.3f}), ratio {of_drawn / without_noise:.2f}"
            )


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
