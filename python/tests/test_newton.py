"""Newton's bodies are drawn where Newton has them."""

import importlib.util
import sys

import numpy as np
import pytest
from conftest import QUICK, ROOT, skip

SIZE = (160, 120)


@pytest.fixture()
def viewer(renderer, monkeypatch):
    if not importlib.util.find_spec("newton"):
        skip("the package newton is not installed")
    monkeypatch.setattr(sys, "path", [str(ROOT / "integrations/newton"), *sys.path])
    import viewer

    return viewer


def test_bodies_are_drawn_where_they_are(viewer):
    import newton

    model = viewer.falling()
    drawn = viewer.GnomonViewer("room", SIZE, layers=["object"], **QUICK)
    drawn.set_model(model)
    drawn.set_camera((6.0, 0.0, 1.5), 0.0, 180.0)
    state = model.state()
    for rise in (0.0, 0.4):
        coordinates = model.joint_q.numpy()
        coordinates[2] = 1.5 + rise
        model.joint_q.assign(coordinates)
        newton.eval_fk(model, model.joint_q, model.joint_qd, state)
        drawn.begin_frame(0)
        drawn.log_state(state)
        drawn.end_frame()
        labels = drawn.radiance["object"]
        drawn.radiance = drawn.radiance["radiance"]
        assert drawn.get_frame().numpy().shape == (120, 160, 3)
        # The sphere: its middle is that of what is seen of it, its radius as wide as its distance says.
        [node] = [node for name, node in drawn.nodes.items() if "shape_1 " in name]
        rows, columns = np.nonzero(labels == node + 1)
        place = viewer.Y_UP[:3, :3] @ state.body_q.numpy()[0, :3]
        [[column, row, depth]] = drawn.camera.project([place], SIZE)
        assert abs(columns.mean() - column) < 0.5 and abs(rows.mean() - row) < 0.5 and depth == pytest.approx(6, abs=1e-3)
        radius = drawn.camera.intrinsics(SIZE)[0, 0] * 0.3 / depth
        assert abs(len(rows) / (np.pi * radius**2) - 1) < 0.06
        for name in ("shape_2 ", "shape_3 "):
            assert (labels == 1 + next(node for key, node in drawn.nodes.items() if name in key)).sum() > 50


def test_the_camera_is_in_the_model_s_world_and_what_is_hidden_is_gone(viewer):
    import newton
    import warp as wp

    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    body = builder.add_body(xform=wp.transform((0, 1.5, 0), wp.quat_identity()))
    builder.add_shape_sphere(body, radius=0.3)
    drawn = viewer.GnomonViewer("room", SIZE, layers=["object"], **QUICK)
    drawn.set_model(builder.finalize())
    # Along -x, from a height of 1.5 m.
    drawn.set_camera((6.0, 1.5, 0.0), 0.0, 180.0)
    sphere = viewer.gnomon.Scene.load("column")
    vertices, triangles = sphere.vertices(0), sphere.triangles(0)
    drawn.log_mesh("sphere", wp.array(vertices, dtype=wp.vec3), wp.array(triangles.flatten(), dtype=wp.int32), hidden=True)

    def seen(places, hidden=False):
        xforms = wp.array([[*place, 0, 0, 0, 1] for place in places], dtype=wp.transform)
        drawn.log_instances("two", "sphere", xforms, None, None, None, hidden=hidden)
        drawn.end_frame()
        return set(np.unique(drawn.radiance["object"])) - {0}

    both = seen([(0, 1, -1), (0, 1, 1)])
    assert len(both) == 2 and len(seen([(0, 1, -1)])) == 1
    assert seen([(0, 1, -1), (0, 1, 1)], hidden=True) == set()
    assert seen([(0, 1, -1), (0, 1, 1)]) == both
