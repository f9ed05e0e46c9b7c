"""Light a scene in which everything moves with an HDR environment map, soft shadows included.

>>> import gnomon
>>> scene = gnomon.Scene.load("three-boxes")
>>> environment = gnomon.Environment.load("room", rotation=30)
>>> renderer = gnomon.Renderer()
>>> radiance = renderer.render(scene, environment=environment, size=(96, 72))
>>> radiance.shape, radiance.dtype
((72, 96, 3), dtype('float32'))

Axes and units are those of CONVENTIONS.md: right-handed, +y up, metres; cameras look along -z; angles are degrees, fields of view
horizontal; sizes are (width, height), arrays (height, width, channels); radiance is linear Rec. 709. Every option of the command
``gnomon render`` is a keyword argument, its dashes underscores: ``shadows="rays"``, ``light_count=96``.
"""

from ._gnomon import (
    Camera,
    Dataset,
    DeviceLost,
    Environment,
    Error,
    Lights,
    Renderer,
    Scene,
    __version__ as __version__,
    adapters,
    check,
    compare,
    fit,
    png,
    read,
    reference,
    tone_map,
    write,
)

__all__ = [
    "Camera",
    "Dataset",
    "DeviceLost",
    "Environment",
    "Error",
    "Lights",
    "Renderer",
    "Scene",
    "adapters",
    "check",
    "compare",
    "fit",
    "png",
    "read",
    "reference",
    "show",
    "tone_map",
    "write",
]


class show:
    """A picture that a notebook displays: radiance exposed by ``exposure`` stops and tone-mapped."""

    def __init__(self, radiance, exposure=0.0, tone_mapping="neutral"):
        self._png = png(radiance, exposure, tone_mapping)

    def _repr_png_(self):
        return self._png
