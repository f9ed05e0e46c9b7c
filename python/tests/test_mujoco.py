"""MuJoCo's models, where they are in MuJoCo's own pictures."""

import os
import sys

import numpy as np
import pytest
from conftest import QUICK, ROOT, skip

SIZE = (160, 120)
MODEL = """
<mujoco>
  <asset>
    <mesh name="wedge" vertex="0 0 0  .3 0 0  0 .3 0  0 0 .3"/>
  </asset>
  <worldbody>
    <geom type="plane" size="3 3 1"/>
    <body pos="0 0 .6"><freejoint/><geom type="box" size=".2 .3 .1" euler="20 30 0"/></body>
    <body pos=".8 0 .7"><freejoint/><geom type="sphere" size=".2"/></body>
    <body pos="-.8 .2 .8"><freejoint/><geom type="capsule" size=".1 .3" euler="60 0 0"/></body>
    <body pos="0 .8 .8"><freejoint/><geom type="cylinder" size=".15 .2" euler="0 70 0"/></body>
    <body pos="-.8 -.7 .9"><freejoint/><geom type="ellipsoid" size=".3 .1 .2" euler="0 0 40"/></body>
    <body pos=".7 -.7 .9"><freejoint/><geom type="mesh" mesh="wedge"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture()
def mujoco():
    os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        import mujoco

        mujoco.Renderer(mujoco.MjModel.from_xml_string(MODEL), 8, 8).close()
    except Exception as error:
        skip(f"MuJoCo does not draw here: {type(error).__name__}")
    return mujoco


def test_geoms_are_seen_where_mujoco_sees_them(mujoco, renderer, room, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "integrations/mujoco"), *sys.path])
    import draw

    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    drawn, view = draw.MujocoScene(model), mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, view)
    view.distance, view.lookat[:] = 4, (0, 0, 0.3)
    camera = draw.camera(view, model.vis.global_.fovy, SIZE)
    with mujoco.Renderer(model, SIZE[1], SIZE[0]) as own:
        own.enable_segmentation_rendering()
        for steps in (0, 90, 210):
            mujoco.mj_step(model, data, steps)
            mujoco.mj_forward(model, data)
            drawn.follow(data)
            own.update_scene(data, view)
            expected = own.render()[:, :, 0]
            labels = renderer.render(drawn.scene, camera, room, SIZE, layers=["object"], **QUICK)["object"]
            for geom, node in drawn.nodes.items():
                is_seen, is_expected = labels == node + 1, expected == geom
                assert is_expected.sum() > 30
                # Curved outlines are of some triangles here and there, and these small ones are mostly outline.
                assert (is_seen & is_expected).sum() > 0.93 * (is_seen | is_expected).sum(), model.geom_type[geom]
            if data.time > 0.2:
                continue
            # While nothing is before the box its corners lie on its outline, at most a pixel off.
            corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * model.geom_size[1]
            world = data.geom_xpos[1] + corners @ data.geom_xmat[1].reshape(3, 3).T
            columns, rows, _ = camera.project(world @ draw.Y_UP[:3, :3].T, SIZE).T
            seen_rows, seen_columns = np.nonzero(expected == 1)
            edges = [seen_columns.min(), seen_columns.max(), seen_rows.min(), seen_rows.max()]
            assert np.abs(np.array([columns.min(), columns.max(), rows.min(), rows.max()]) - edges).max() < 1
