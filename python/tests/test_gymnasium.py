"""The environment for Gymnasium, by Gymnasium's own checks."""

import importlib.util
import sys

import numpy as np
import pytest
from conftest import QUICK, ROOT, skip


@pytest.fixture()
def pointing(renderer, monkeypatch):
    if not importlib.util.find_spec("gymnasium"):
        skip("the package gymnasium is not installed")
    monkeypatch.setattr(sys, "path", [str(ROOT / "integrations/gymnasium"), *sys.path])
    import pointing

    return pointing


@pytest.mark.filterwarnings("ignore")
def test_it_is_an_environment_and_shows_what_is_done(pointing):
    from gymnasium.utils.env_checker import check_env

    env = pointing.Pointing(size=(48, 36), **QUICK)
    check_env(env, skip_render_check=True)
    first, _ = env.reset(seed=3)
    assert np.array_equal(env.reset(seed=3)[0], first) and not np.array_equal(env.reset(seed=4)[0], first)
    # The nearer the arm points to the block, the better.
    off = (env.wanted - env.angle + 180) % 360 - 180
    rewards = []
    for _ in range(pointing.STEPS):
        _, reward, is_there, _, _ = env.step([np.clip(off / pointing.STEP, -1, 1)])
        off = (env.wanted - env.angle + 180) % 360 - 180
        rewards.append(reward)
        if is_there:
            break
    assert is_there and rewards == sorted(rewards)
    # And then its direction is that of the block.
    tip, block = env.scene.world_pose("arm") @ (1.4, 0, 0, 1), env.scene.world_pose("block")[:, 3]
    assert np.allclose(tip, block, atol=0.1)
