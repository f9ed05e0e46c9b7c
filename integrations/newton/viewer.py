"""A viewer for Newton, the physics engine, whose frames Gnomon draws: on a processor too, as both run without a graphics processor.

    python integrations/newton/viewer.py --env grace.hdr --frames 50 -o frames

`GnomonViewer` takes the place of `newton.viewer.ViewerGL` where frames are wanted and no window: `log_state` moves the scene, `end_frame` draws it,
`get_frame` gives the picture, and `radiance` what it was made of.
"""

import argparse
from pathlib import Path

import gnomon
import newton
import numpy as np
import warp as wp

# From +z up to +y up.
Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], np.float64)
FOV_Y = 45.0
"""As Newton's own camera [degrees]."""


def linear(color):
    """Linear values of sRGB ones."""
    color = np.asarray(color, np.float64)
    return np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def matrices(xforms, scales):
    """Transforms (position, quaternion x y z w) and scales as matrices (n, 4, 4)."""
    x, y, z, w = xforms[:, 3:].T
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]  # fmt: skip
    found = np.tile(np.eye(4), (len(xforms), 1, 1))
    found[:, :3, :3] = np.moveaxis(np.array(turn), 2, 0) * scales[:, None, :]
    found[:, :3, 3] = xforms[:, :3]
    return found


# What is hidden is a point.
HIDDEN = np.diag([0.0, 0.0, 0.0, 1.0])


class GnomonViewer(newton.viewer.ViewerBase):
    """Meshes become nodes: each instance one, and each mesh that is not hidden, whose vertices may move. Lines and points are not drawn, and what
    is translucent is drawn opaque. Colours and finishes are those of the first frame."""

    def __init__(self, environment="room", size=(320, 240), **options):
        super().__init__()
        self.environment, self.size, self.options = gnomon.Environment.load(environment), size, options
        self.renderer, self.scene = gnomon.Renderer(), gnomon.Scene()
        self.meshes, self.nodes, self.shown = {}, {}, {}
        self.radiance = None
        self.view = (8.0, 0.0, 2.0), -10.0, 180.0

    @property
    def world(self):
        """From Newton's world to Gnomon's."""
        return Y_UP if self.is_z_up else np.eye(4)

    @property
    def is_z_up(self):
        return self.model is None or newton.Axis.from_any(self.model.up_axis) == newton.Axis.Z

    def set_camera(self, pos, pitch=None, yaw=None):
        """Puts the camera somewhere; it looks along +x where both angles are 0 [degrees]. Those that are not given stay."""
        _, pitch_before, yaw_before = self.view
        self.view = tuple(map(float, pos)), pitch_before if pitch is None else pitch, yaw_before if yaw is None else yaw

    @property
    def camera(self):
        """As :meth:`set_camera` has put it in the world of the model."""
        eye, (pitch, yaw) = np.array(self.view[0]), np.radians(self.view[1:])
        along, aside, up = np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)
        forward = np.array([along, aside, up] if self.is_z_up else [along, up, aside])
        eye, target = (self.world[:3, :3] @ place for place in (eye, eye + forward))
        fx = 0.5 * self.size[1] / np.tan(np.radians(FOV_Y) / 2)
        return gnomon.Camera(eye=eye.tolist(), target=target.tolist(), fx=fx, size=self.size)

    def hide(self, key):
        if key in self.nodes:
            self.scene.set_pose(self.nodes[key], HIDDEN)

    def log_mesh(self, name, points, indices, normals=None, uvs=None, texture=None, hidden=False, backface_culling=True, color=None, roughness=None, metallic=None, **kwargs):  # fmt: skip
        vertices, triangles = points.numpy(), indices.numpy().reshape(-1, 3)
        normals = None if normals is None else normals.numpy()
        self.meshes[name] = vertices, triangles, normals
        if hidden:
            self.hide(name)
            return
        if name in self.nodes and len(self.scene.vertices(self.nodes[name])) != len(vertices):
            # A node's triangles stay: another mesh is another node.
            self.hide(name)
            del self.nodes[name]
        if name in self.nodes:
            self.scene.set_vertices(self.nodes[name], vertices, normals)
            self.scene.set_pose(self.nodes[name], self.world)
        else:
            finish = {key: value for key, value in (("roughness", roughness), ("metallic", metallic)) if value is not None}
            self.nodes[name] = self.scene.add_mesh(
                name, vertices, triangles, normals=normals, pose=self.world, base_color=linear(color or (0.7, 0.7, 0.7)), **finish
            )

    def log_instances(self, name, mesh, xforms, scales, colors, materials, hidden=False, opacities=None):
        xforms = np.zeros((0, 7)) if xforms is None or hidden else xforms.numpy()
        for number in range(len(xforms), self.shown.get(name, 0)):
            self.hide(f"{name} {number}")
        self.shown[name] = len(xforms)
        scales = np.ones((len(xforms), 3)) if scales is None else scales.numpy()
        colors = np.full((len(xforms), 3), 0.7) if colors is None else colors.numpy()
        # Roughness and metallic share come first.
        materials = np.tile((0.6, 0.0), (len(xforms), 1)) if materials is None else materials.numpy()
        for number, pose in enumerate(matrices(xforms, scales)):
            key = f"{name} {number}"
            if key not in self.nodes:
                vertices, triangles, normals = self.meshes[mesh]
                roughness, metallic = map(float, materials[number][:2])
                self.nodes[key] = self.scene.add_mesh(
                    key,
                    vertices,
                    triangles,
                    normals=normals,
                    base_color=linear(colors[number]),
                    roughness=roughness,
                    metallic=metallic,
                )
            self.scene.set_pose(self.nodes[key], self.world @ pose)

    def end_frame(self):
        self.radiance = self.renderer.render(self.scene, self.camera, self.environment, self.size, **self.options)

    def get_frame(self, *, output=None, render_ui=False):
        shown = wp.array(gnomon.tone_map(self.radiance, self.environment.exposure), dtype=wp.uint8, device=self.device)
        if output is None:
            return shown
        wp.copy(output, shown)
        return output

    def log_lines(self, *arguments, **kwargs): ...
    def log_points(self, *arguments, **kwargs): ...
    def log_gaussian(self, *arguments, **kwargs): ...
    def log_array(self, *arguments, **kwargs): ...
    def log_scalar(self, *arguments, **kwargs): ...
    def apply_forces(self, state): ...
    def close(self): ...


def falling():
    """A few bodies above a ground."""
    builder = newton.ModelBuilder()
    builder.add_ground_plane()
    for number, place in enumerate([(0, 0, 1.5), (0.3, 0.9, 2), (-0.2, -0.9, 1.2)]):
        body = builder.add_body(xform=wp.transform(place, wp.quat_from_axis_angle(wp.vec3(1, 0, 0), 0.5)))
        add = [builder.add_shape_sphere, builder.add_shape_box, builder.add_shape_capsule][number]
        add(body, **[{"radius": 0.3}, {"hx": 0.2, "hy": 0.3, "hz": 0.15}, {"radius": 0.15, "half_height": 0.3}][number])
    return builder.finalize()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--env", default="sky")
    parser.add_argument("--frames", type=int, default=50)
    parser.add_argument("-o", "--output", type=Path, default=Path("frames"))
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    model = falling()
    viewer, solver = GnomonViewer(given.env), newton.solvers.SolverXPBD(model)
    viewer.set_model(model)
    viewer.set_camera(wp.vec3(6.0, 0.0, 2.0), -12.0, 180.0)
    before, after, collisions = model.state(), model.state(), newton.CollisionPipeline(model)
    contacts = collisions.contacts()
    newton.eval_fk(model, model.joint_q, model.joint_qd, before)
    for frame in range(given.frames):
        viewer.begin_frame(frame / 25)
        viewer.log_state(before)
        viewer.end_frame()
        gnomon.write(given.output / f"{frame:04}.png", viewer.radiance, viewer.environment.exposure)
        for _ in range(8):
            before.clear_forces()
            collisions.collide(before, contacts)
            solver.step(before, after, model.control(), contacts, 1 / 200)
            before, after = after, before


if __name__ == "__main__":
    main()
