"""A Gymnasium environment whose observations are drawn by Gnomon: an arm learns to point at a block, by what a camera sees.

    python integrations/gymnasium/pointing.py --env grace.hdr

Every episode has another place of the block and another turn of the environment map: what is learnt is not the light. The arm is a node that
:meth:`gnomon.Scene.set_joint` turns, so a step uploads a pose and draws.
"""

import argparse
from pathlib import Path

import gnomon
import gymnasium
import numpy as np

BOX = np.array([[x, y, z] for x in (0, 1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)], np.float32)
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
TRIANGLES = [corners for a, b, c, d in QUADS for corners in ([a, b, c], [a, c, d])]
STEP = 15.0
"""Largest turn of one step [degrees]."""
STEPS = 24
"""Of an episode."""


def linear(shown):
    """Linear values of sRGB ones."""
    return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


class Pointing(gymnasium.Env):
    """The action turns the arm; the reward is 0 where it points at the block, else less by the angle between [rad]."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(self, environment="room", size=(96, 72), render_mode="rgb_array", **options):
        self.render_mode, self.size = render_mode, size
        # Few lights and small maps are enough for so small a picture.
        self.options = {"light_count": 16, "supersample": 1, **options}
        self.action_space = gymnasium.spaces.Box(-1, 1, (1,), np.float32)
        self.observation_space = gymnasium.spaces.Box(0, 255, (size[1], size[0], 3), np.uint8)
        self.renderer, self.environment = gnomon.Renderer(), gnomon.Environment.load(environment)
        self.scene = gnomon.Scene(ground="fade")
        self.arm = self.scene.add_mesh("arm", BOX, TRIANGLES, base_color=(0.7, 0.2, 0.1), roughness=0.4)
        self.block = self.scene.add_mesh("block", BOX - (0.5, 0, 0), TRIANGLES, base_color=(0.1, 0.3, 0.7))
        self.camera = gnomon.Camera(eye=(0, 4, 3), target=(0, 0, 0), fov=50)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.angle, self.wanted = self.np_random.uniform(-180, 180, 2)
        self.light, self.steps = self.environment.rotated(self.np_random.uniform(0, 360)), 0
        turn, pose = np.radians(self.wanted), np.diag([0.3, 1.5, 1.5, 1])
        # As the arm's tip turns about +y, beyond its end.
        pose[:3, 3] = 1.4 * np.cos(turn), 0, -1.4 * np.sin(turn)
        self.scene.set_pose(self.block, pose)
        return self.render(), {}

    def step(self, action):
        self.angle += STEP * float(np.clip(action[0], -1, 1))
        self.steps += 1
        off = np.radians((self.angle - self.wanted + 180) % 360 - 180)
        return self.render(), -abs(off), bool(abs(off) < 0.05), self.steps >= STEPS, {}

    def render(self):
        """What the camera sees, (height, width, 3), sRGB."""
        self.scene.set_joint(self.arm, self.angle, axis=(0, 1, 0))
        radiance = self.renderer.render(self.scene, self.camera, self.light, self.size, **self.options)
        return gnomon.tone_map(radiance, self.light.exposure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--env", default="room")
    parser.add_argument("--episodes", type=int, default=3)
    parser.add_argument("-o", "--output", type=Path, help="folder for the pictures")
    given = parser.parse_args()
    if given.output:
        given.output.mkdir(parents=True, exist_ok=True)
    env = Pointing(given.env)
    for episode in range(given.episodes):
        env.reset(seed=episode)
        total, is_over = 0, False
        while not is_over:
            # Whoever learns puts a policy here; this one knows where the block is.
            off = (env.wanted - env.angle + 180) % 360 - 180
            observation, reward, is_there, is_late, _ = env.step([off / STEP])
            total, is_over = total + reward, is_there or is_late
        print(f"episode {episode}: {env.steps} steps, return {total:.2f}")
        if given.output:
            gnomon.write(given.output / f"{episode}.png", linear(observation / 255.0), tone_mapping="linear")


if __name__ == "__main__":
    main()
