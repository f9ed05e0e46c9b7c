#!/usr/bin/env python3
"""Errors of the default on scenes that no default was chosen on: each is made here, drawn under several maps and checked by its own traced pixels.

    tools/unseen_scenes.py GNOMON DATA FOLDER [OPTION...]

writes the scenes as OBJ files to FOLDER, draws them at 256 x 192 pixels with the options, and prints what `--check 1500` says (relative RMSE against
ray-traced truth in percent, and one standard error). Needs numpy.
"""
import json
import math
import pathlib
import random
import subprocess
import sys

import numpy as np

MAPS = {
    "rooitou": "cc0_rooitou_park_1k.hdr",
    "kiara": "cc0_kiara_1_dawn_1k.hdr",
    "galileo": "debevec_galileo_cross.hdr",
    "rnl": "debevec_rnl_cross.hdr",
}
MATTE = "Ks 0 0 0\n"
GROUND, LIGHT = ("ground", 0.5, MATTE), ("light", 0.7, MATTE)


class Model:
    """Polygons with materials, and a view of them."""

    def __init__(self, camera):
        self.camera = camera
        self.corners, self.lines, self.materials = [], [], {}

    def material(self, name, albedo, more):
        self.materials[name] = f"newmtl {name}\nKd {albedo} {albedo} {albedo}\n{more}"
        self.lines.append(f"usemtl {name}")

    def polygon(self, *corners):
        first = len(self.corners) + 1
        self.corners.extend(corners)
        self.lines.append("f " + " ".join(str(first + i) for i in range(len(corners))))

    def ground(self, half):
        self.material(*GROUND)
        self.polygon((-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half))
        self.material(*LIGHT)

    def box(self, center, half):
        for axis in range(3):
            for side in (-1, 1):
                square = [(-1, -1), (1, -1), (1, 1), (-1, 1)][::side]
                corners = []
                for s, t in square:
                    corner = np.zeros(3)
                    corner[[axis, (axis + 1) % 3, (axis + 2) % 3]] = side, s, t
                    corners.append(tuple(np.asarray(center) + corner * half))
                self.polygon(*corners)

    def turned(self, profile, center, sides=48):
        """A profile of (radius, height) turned about the vertical through `center`."""
        angles = np.linspace(0, 2 * math.pi, sides + 1)
        rings = [[(center[0] + r * math.cos(a), center[1] + y, center[2] + r * math.sin(a)) for a in angles] for r, y in profile]
        for low, high in zip(rings, rings[1:]):
            for i in range(sides):
                self.polygon(low[i], high[i], high[i + 1], low[i + 1])

    def ball(self, center, radius):
        angles = np.linspace(1e-4, math.pi - 1e-4, 24)
        self.turned([(radius * math.sin(a), -radius * math.cos(a)) for a in angles], center)

    def rod(self, start, end, radius, sides=8):
        start, end = np.asarray(start, float), np.asarray(end, float)
        along = (end - start) / np.linalg.norm(end - start)
        u = np.cross(along, (0, 1, 0) if abs(along[1]) < 0.9 else (1, 0, 0))
        u /= np.linalg.norm(u)
        w = np.cross(along, u)
        around = [radius * (math.cos(a) * u + math.sin(a) * w) for a in np.linspace(0, 2 * math.pi, sides + 1)]
        for a, b in zip(around, around[1:]):
            self.polygon(tuple(start + a), tuple(start + b), tuple(end + b), tuple(end + a))
        for middle, turn in ((start, -1), (end, 1)):
            self.polygon(*[tuple(middle + a) for a in around[:-1][::turn]])

    def write(self, folder, name):
        (folder / f"{name}.mtl").write_text("\n".join(self.materials.values()))
        vertices = ["v %.6f %.6f %.6f" % corner for corner in self.corners]
        (folder / f"{name}.obj").write_text("\n".join([f"mtllib {name}.mtl", *vertices, *self.lines, ""]))


def pergola():
    m = Model("eye=3.4,2.2,4.2; target=0,0.8,0; fov=48")
    m.ground(12)
    for x in (-1.5, 1.5):
        for z in (-1.2, 1.2):
            m.box((x, 1.1, z), (0.06, 1.1, 0.06))
    for z in (-1.2, 1.2):
        m.box((0, 2.24, z), (1.8, 0.04, 0.05))
    for i in range(19):
        m.box((-1.8 + 0.2 * i, 2.33, 0), (0.02, 0.05, 1.5))
    m.ball((0.5, 0.4, 0.3), 0.4)
    for i in range(4):
        m.box((-1, 0.1 + 0.2 * i, -0.2 - 0.25 * i), (0.6, 0.1, 0.15))
    return m


def stairs():
    m = Model("eye=-2.5,2.4,4.6; target=0.3,0.7,0; fov=50")
    m.ground(15)
    for i in range(9):
        x, y = -2 + 0.32 * i, 0.16 * (i + 1)
        m.box((x, y / 2, 0), (0.16, y / 2, 0.9))
        for z in (-0.85, 0.85):
            m.rod((x, y, z), (x, y + 0.75, z), 0.012)
    for z in (-0.85, 0.85):
        m.rod((-2, 0.91, z), (0.56, 2.19, z), 0.03)
        m.box((2.75, 0.4, z), (0.05, 0.4, 0.05))
    m.box((1.9, 0.85, 0), (1.0, 0.05, 0.9))
    m.ball((2.0, 1.1, 0.2), 0.2)
    return m


def bicycle():
    m = Model("eye=1.2,1.5,2.6; target=0.2,0.4,0; fov=50")
    m.ground(10)
    for hub in (-0.6, 0.6):
        rim = [(hub + 0.34 * math.cos(a), 0.36 + 0.34 * math.sin(a), 0) for a in np.linspace(0, 2 * math.pi, 41)]
        for i, (start, end) in enumerate(zip(rim, rim[1:])):
            m.rod(start, end, 0.018)
            if i % 2 == 0:
                m.rod((hub, 0.36, 0.03 * (-1) ** (i // 2)), start, 0.003, 6)
    back, foot, front = (-0.6, 0.36, 0), (0, 0.3, 0), (0.6, 0.36, 0)
    for start, end in [(back, (-0.25, 0.85, 0)), ((-0.25, 0.85, 0), (0.42, 0.8, 0)), (front, (0.38, 1.0, 0)), (back, foot),
                       (foot, (-0.25, 0.95, 0)), (foot, (0.42, 0.78, 0)), ((0.38, 1.0, -0.25), (0.38, 1.0, 0.25))]:
        m.rod(start, end, 0.018, 10)
    m.box((-0.27, 0.97, 0), (0.13, 0.025, 0.07))
    m.box((0, 0.8, -0.9), (1.6, 0.8, 0.05))
    for i in range(14):
        m.box((1.4, 0.45, -0.6 + 0.1 * i), (0.25, 0.012, 0.03))
    return m


def street():
    """A handcart between houses: small things in a large scene, most of the sky hidden."""
    m = Model("eye=-2.2,2.0,4.5; target=0.3,0.8,-2; fov=55")
    m.ground(80)
    heights = random.Random(3)
    for i in (-4, -3, -2, -1, 1, 2, 3, 4):
        for j in range(-6, 1):
            h = heights.uniform(4, 22)
            m.box((i * 11 + 2 * np.sign(i), h, j * 12 - 4), (4, h, 4.5))
    m.box((0, 0.4, -1.5), (0.9, 0.03, 0.5))
    for x in (-0.85, 0.85):
        for z in (-1.95, -1.05):
            m.rod((x, 0, z), (x, 0.4, z), 0.03)
    m.ball((0.3, 0.65, -1.5), 0.22)
    m.box((-0.4, 0.55, -1.4), (0.2, 0.12, 0.2))
    return m


def porch():
    m = Model("eye=3.2,1.7,4.2; target=-0.2,1.0,-0.8; fov=52")
    m.ground(14)
    m.box((0, 2.7, -0.6), (2.6, 0.08, 1.9))
    m.box((0, 1.3, -2.4), (2.5, 1.3, 0.08))
    m.box((-2.45, 1.3, -0.6), (0.06, 1.3, 1.8))
    for x in (-2.4, -0.8, 0.8, 2.4):
        m.box((x, 1.3, 1.15), (0.05, 1.3, 0.05))
    m.box((0, 0.08, -0.6), (2.5, 0.08, 1.8))
    m.box((-0.4, 0.6, -1.8), (0.9, 0.025, 0.28))
    for x in (-1.2, 0.4):
        for z in (-2.0, -1.6):
            m.box((x, 0.37, z), (0.03, 0.21, 0.03))
    m.ball((1.3, 0.46, -0.4), 0.3)
    for i in range(16):
        m.rod((-0.8 + 0.1 * i, 0.16, 1.15), (-0.8 + 0.1 * i, 0.9, 1.15), 0.01)
    return m


def courtyard():
    m = Model("eye=-4.9,1.8,5.2; target=-4.2,0.9,-3; fov=62")
    m.ground(30)
    for side in (-1, 1):
        m.box((side * 7, 4, 0), (0.3, 4, 9))
        m.box((side * 5.5, 3.4, 0), (1.6, 0.15, 9))
        for i in range(7):
            m.box((side * 4, 1.65, -7.5 + 2.5 * i), (0.2, 1.65, 0.2))
    for z in (-9.3, 9.3):
        m.box((0, 4, z), (7.3, 4, 0.3))
    m.box((-5.5, 0.4, -2), (0.3, 0.03, 1.0))
    m.ball((-5.2, 0.3, 0.6), 0.3)
    return m


SCENES = {scene.__name__: scene for scene in (pergola, stairs, bicycle, street, porch, courtyard)}


def main(gnomon, data, folder, *options):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    print("| scene | " + " | ".join(MAPS) + " |\n" + "|---" * (len(MAPS) + 1) + "|")
    errors = []
    for name, scene in SCENES.items():
        model = scene()
        model.write(folder, name)
        cells = []
        for map_name, file in MAPS.items():
            stats = folder / "stats.json"
            subprocess.run(
                [gnomon, "render", str(folder / f"{name}.obj"), "--camera", model.camera, "--ground", "none", "--size", "256x192",
                 "--env", str(pathlib.Path(data) / "env" / file), "--check", "1500", "--stats", str(stats), "-q",
                 "-o", str(folder / f"{name}_{map_name}.png"), *options], check=True)
            check = json.loads(stats.read_text())["check"]
            errors.append(check["relative_rmse"])
            cells.append(f"{check['relative_rmse']:.4f} ± {check['uncertainty']:.4f}")
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)
    print(f"mean {sum(errors) / len(errors):.4f}, worst {max(errors):.4f}")


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
