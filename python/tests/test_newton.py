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
