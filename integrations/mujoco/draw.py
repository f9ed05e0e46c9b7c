"""A MuJoCo model drawn by Gnomon, frame by frame from its poses.

    python integrations/mujoco/draw.py humanoid.xml --env grace.hdr --frames 100 -o frames

`MujocoScene` is what a program of its own needs: made once of a model, and moved by `follow(data)`.
"""

import argparse
from pathlib import Path

import gnomon
import mujoco
import numpy as np

# MuJoCo's world has +z up.
Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], np.float64)
PLANE = 20
"""Half the side of a plane that MuJoCo takes as endless [m]."""


def grid(rows, columns):
    """Triangles of a grid of vertices, row by row."""
    corner = np.arange((rows - 1) * columns).reshape(rows - 1, columns)[:, :-1].ravel()
    lower, upper = corner + columns, corner + columns + 1
    return np.concatenate([np.stack([corner, lower, upper], 1), np.stack([corner, upper, corner + 1], 1)])


def turned(radii, heights, normals_out, normals_up, columns=33):
    """A surface of revolution about z: vertices, normals and triangles, from the top down."""
    angles = np.linspace(0, 2 * np.pi, columns)
    around = np.stack([np.cos(angles), np.sin(angles)], 1)

    def rows(out, up):
        parts = [np.column_stack([r * around, np.full(columns, z)]) for r, z in zip(out, up, strict=True)]
        return np.concatenate(parts)

    return rows(radii, heights), rows(normals_out, normals_up), grid(len(radii), columns)


def shape(model, geom):
    """Vertices, triangles and normals of a geom in its own frame; normals are None where faces are flat."""
    kind, size = mujoco.mjtGeom(model.geom_type[geom]), model.geom_size[geom]
    arc = np.linspace(0, np.pi, 17)
    if kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_ELLIPSOID):
        scale = np.full(3, size[0]) if kind == mujoco.mjtGeom.mjGEOM_SPHERE else size
        vertices, normals, triangles = turned(np.sin(arc), np.cos(arc), np.sin(arc), np.cos(arc))
        normals = normals / scale
        return vertices * scale, triangles, normals / np.linalg.norm(normals, axis=1, keepdims=True)
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        arc = np.concatenate([arc[:9], arc[8:]])
        heights = size[0] * np.cos(arc) + np.repeat([size[1], -size[1]], 9)
        vertices, normals, triangles = turned(size[0] * np.sin(arc), heights, np.sin(arc), np.cos(arc))
        return vertices, triangles, normals
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        radii, heights = size[0] * np.array([0, 1, 1, 1, 1, 0]), size[1] * np.array([1, 1, 1, -1, -1, -1])
        vertices, normals, triangles = turned(radii, heights, [0, 0, 1, 1, 0, 0], [1, 1, 0, 0, -1, -1])
        return vertices, triangles, normals
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        return corners * size, [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])], None
    if kind == mujoco.mjtGeom.mjGEOM_PLANE:
        half = [side if side > 0 else PLANE for side in size[:2]]
        return np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * [*half, 1], [[0, 1, 2], [0, 2, 3]], None
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        start, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        return model.mesh_vert[first : first + count], model.mesh_face[start : start + faces], None
    return None


def linear(color):
    """Linear values of sRGB ones, as MuJoCo's colours are."""
    return np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def base_color(model, geom):
    """A geom's colour; of a texture the mean."""
    material = model.geom_matid[geom]
    if material < 0:
        return linear(model.geom_rgba[geom, :3])
    texture = model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB]
    if texture < 0:
        return linear(model.mat_rgba[material, :3])
    first, channels = model.tex_adr[texture], model.tex_nchannel[texture]
    texels = model.tex_data[first : first + model.tex_height[texture] * model.tex_width[texture] * channels]
    mean = linear(texels.reshape(-1, channels)[:, :3] / 255).mean(0)
    return mean * linear(model.mat_rgba[material, :3])


class MujocoScene:
    """A Gnomon scene of a model's geoms, those of groups 0 to 2, which MuJoCo shows."""

    def __init__(self, model):
        self.scene = gnomon.Scene()
        self.nodes = {}
        for geom in range(model.ngeom):
            made = shape(model, geom) if model.geom_group[geom] < 3 else None
            if made is None:
                continue
            vertices, triangles, normals = made
            name, color = f"{geom} {model.geom(geom).name}", base_color(model, geom)
            self.nodes[geom] = self.scene.add_mesh(
                name, vertices, triangles, normals=normals, base_color=color, roughness=0.6
            )

    def follow(self, data):
        """Puts every geom where MuJoCo has it."""
        for geom, node in self.nodes.items():
            pose = np.eye(4)
            pose[:3, :3] = data.geom_xmat[geom].reshape(3, 3)
            pose[:3, 3] = data.geom_xpos[geom]
            self.scene.set_pose(node, Y_UP @ pose)


def camera(view, fovy, size):
    """MuJoCo's free camera for pictures of this size; `fovy` is vertical [degrees]."""
    azimuth, elevation = np.radians([view.azimuth, view.elevation])
    forward = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    eye = (Y_UP[:3, :3] @ (view.lookat - view.distance * forward)).tolist()
    width, height = size
    fx = 0.5 * height / np.tan(np.radians(fovy) / 2)
    return gnomon.Camera(eye=eye, target=Y_UP[:3, :3] @ view.lookat, fx=fx, size=(width, height))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model")
    parser.add_argument("--env", default="sky")
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--fps", type=float, default=25)
    parser.add_argument("--size", type=int, nargs=2, default=(320, 240))
    parser.add_argument("-o", "--output", type=Path, default=Path("frames"))
    given = parser.parse_args()
    model = mujoco.MjModel.from_xml_path(given.model)
    data = mujoco.MjData(model)
    drawn, renderer = MujocoScene(model), gnomon.Renderer()
    environment = gnomon.Environment.load(given.env)
    view = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, view)
    given.output.mkdir(parents=True, exist_ok=True)
    for frame in range(given.frames):
        while data.time < frame / given.fps:
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        drawn.follow(data)
        radiance = renderer.render(drawn.scene, camera(view, model.vis.global_.fovy, given.size), environment, given.size)
        gnomon.write(given.output / f"{frame:04}.png", radiance, environment.exposure)


if __name__ == "__main__":
    main()
