"""Stubs of the package: shapes, units and errors of everything that it has.

Whatever cannot be had raises :class:`Error` with the sentence that the command says. ``Any`` among keyword arguments are options of
``gnomon render``; ``gnomon render --help`` describes each.
"""

from collections.abc import Callable
from os import PathLike
from typing import Any, Literal, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Size: TypeAlias = tuple[int, int]
"""Width and height [pixels]."""
Radiance: TypeAlias = NDArray[np.float32]
"""(height, width, 3), linear Rec. 709, top row first."""
Layers: TypeAlias = dict[str, NDArray[Any]]
"""``radiance``, and layers by their names: ``depth`` (height, width) [m], infinite behind the scene; ``normal``, ``position``, ``albedo``,
``shadow``, ``diffuse``, ``specular`` (height, width, 3); ``uv`` (height, width, 2); ``alpha`` (height, width); ``object`` and ``material``
(height, width) uint32, the number of the node and of the material plus 1, 0 behind the scene. ``gnomon render --help`` describes them."""
Progress: TypeAlias = Callable[[float], object]
"""Called with the finished share, 0..1, on the calling thread. What it raises stops the work."""
Node: TypeAlias = str | int
"""A node by its name, or its number from 0."""

class Error(Exception):
    """What was asked for cannot be had; the text is one line that says why and what to do."""

class DeviceLost(Error):
    """The graphics device is gone, as after a driver's reset. The renderer's next call opens it anew."""

class Camera:
    """A view. It does not change, and can be pickled."""

    @overload
    def __init__(self, text: str, /) -> None:
        """As the command's ``--camera``: ``"eye=3,2,4; target=0,0.5,0; fov=40"``."""

    @overload
    def __init__(
        self,
        *,
        eye: ArrayLike = ...,
        target: ArrayLike = ...,
        world_from_camera: ArrayLike = ...,
        fov: float = ...,
        half_width: float = ...,
        fx: float = ...,
        fy: float = ...,
        cx: float = ...,
        cy: float = ...,
        size: Size = ...,
        shift: tuple[float, float] = ...,
    ) -> None:
        """A place by ``eye`` and ``target`` [m] or by ``world_from_camera``, (4, 4), rigid: right, up, back, eye. A lens by ``fov``
        [degrees, horizontal]; by ``fx``, ``fy``, ``cx``, ``cy`` [pixels] of pictures of ``size``, as OpenCV has them; or, of a parallel
        view, by ``half_width`` [m]."""

    @property
    def world_from_camera(self) -> NDArray[np.float32]:
        """(4, 4)."""

    @property
    def eye(self) -> list[float]:
        """[m]."""

    def intrinsics(self, size: Size) -> NDArray[np.float32]:
        """OpenCV's matrix of a pinhole for pictures of this size, (3, 3) [pixels]."""

    def project(self, points: ArrayLike, size: Size) -> NDArray[np.float32]:
        """Of points (n, 3) [m] in world space: column and row [pixels], counted as OpenCV does, and depth along the axis [m], (n, 3)."""

class Environment:
    """What is infinitely far around a scene. It does not change, is shared by copies, and can be pickled."""

    @staticmethod
    def load(
        source: str | PathLike[str] | bytes | ArrayLike,
        *,
        rotation: float = 0.0,
        strength: float = 1.0,
        tint: float | tuple[float, float, float] = 1.0,
        projection: str | None = None,
        layer: str | None = None,
        rig: str | None = None,
        background_map: str | None = None,
        clamp: float | None = None,
    ) -> Environment:
        """A Radiance .hdr or OpenEXR file, its bytes, ``"room"`` or ``"sky"``, or an equirect map (n, 2 n, 3) of radiance. ``rotation``
        [degrees] turns it about +y, ``strength`` and ``tint`` multiply its light."""

    def rotated(self, degrees: float) -> Environment:
        """The same turned to this angle; the map is shared, and nothing is fitted anew for it."""

    def graded(self, *, strength: float = ..., tint: float | tuple[float, float, float] = ...) -> Environment:
        """The same of another strength or tint: what is not given stays. The map is shared, and nothing is fitted anew for it."""

    @property
    def rotation(self) -> float:
        """[degrees]."""

    @property
    def exposure(self) -> float:
        """Stops that bring the mean of its file to 0.5."""

    @property
    def radiance(self) -> Radiance:
        """The map that lights, not turned."""

    @property
    def warnings(self) -> list[str]:
        """What had to be repaired, a line each."""

class Lights:
    """Area lights that stand for an environment, and the map that they leave."""

    def __len__(self) -> int: ...
    @property
    def method(self) -> str: ...
    @property
    def directions(self) -> NDArray[np.float32]:
        """Unit vectors towards the lights, (n, 3)."""

    @property
    def radiance(self) -> NDArray[np.float32]:
        """(n, 3)."""

    @property
    def solid_angles(self) -> NDArray[np.float32]:
        """(n,) [sr]."""

    @property
    def residual(self) -> Radiance:
        """What the lights leave of the map."""

    def to_json(self) -> str:
        """As ``gnomon decompose`` writes them."""

class Scene:
    """Meshes, materials, cameras and a pose. It is changed in place; :meth:`copy` shares meshes and textures. Pickled, a scene is where it
    was loaded from, with what was changed: a file has to be there where it is unpickled."""

    def __init__(self, **options: Any) -> None:
        """An empty scene, for :meth:`add_mesh`. ``ground="fade"`` (or ``"plane"``, ``"catcher"``) lays a ground under what is added."""

    @staticmethod
    def load(
        source: str | PathLike[str] | bytes,
        *,
        format: str | None = None,
        up: Literal["y", "z"] = ...,
        unit: float | str = ...,
        variant: str | None = None,
        ground: Literal["none", "plane", "catcher", "fade", "projected"] = ...,
        clip: str | None = None,
        time: float = 0.0,
        size: Size = ...,
        **options: Any,
    ) -> Scene:
        """A file (glTF, OBJ, PLY, STL, TOML), a built-in scene, or the bytes of a file in itself, whose extension ``format`` is. What is
        given here goes before what the file says, and what is given to a call before both. A camera of a glTF file has a vertical angle
        of view: it is taken for pictures of ``size``."""

    @property
    def nodes(self) -> list[str]: ...
    @property
    def parents(self) -> list[int | None]:
        """Number of each node's parent; None for a root. Parents come before children."""

    @property
    def materials(self) -> list[str]: ...
    @property
    def cameras(self) -> list[str]: ...
    @property
    def clips(self) -> list[tuple[str, float]]:
        """Names and durations [s]."""

    @property
    def warnings(self) -> list[str]: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def bounds(self) -> tuple[list[float], list[float]] | None:
        """Box around the models as they stand [m], without the ground."""

    @property
    def environment(self) -> Environment | None:
        """That which its file names."""

    def camera(self, name: str | None = None, size: Size | None = None) -> Camera:
        """One of :attr:`cameras`; without a name the first, or one that frames the models in pictures of this size."""

    def pose(self, node: Node) -> NDArray[np.float32]:
        """``parent_from_node``, (4, 4)."""

    def world_pose(self, node: Node) -> NDArray[np.float32]:
        """``world_from_node``, (4, 4)."""

    def set_pose(self, node: Node, parent_from_node: ArrayLike) -> None:
        """Moves a node, (4, 4); what a clip plays goes before it."""

    def set_joint(self, node: Node, degrees: float, axis: tuple[float, float, float] = (0, 0, 1)) -> None:
        """Turns a node from where it was loaded about an axis of its own, by the right-hand rule."""

    def play(self, clip: str | None, time: float = 0.0) -> None:
        """Puts the models where a clip has them at a time [s]; beyond its end it starts again."""

    def material(self, material: Node) -> dict[str, Any]:
        """Model and parameters of a material, as it is drawn."""

    def set_material(self, material: Node, *, model: str | None = None, **parameters: float | ArrayLike) -> None:
        """Changes parameters (``base_color=(0.8, 0.1, 0.1), roughness=0.3``), or the model; ``gnomon render --help`` lists them at
        ``--reflectance``."""

    def add_mesh(
        self,
        name: str,
        vertices: ArrayLike,
        triangles: ArrayLike,
        *,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        pose: ArrayLike | None = None,
        model: str | None = None,
        **parameters: float | ArrayLike,
    ) -> int:
        """Adds a mesh at the root, with a material of its name: vertices (n, 3) [m], triangles (m, 3), counter-clockwise seen from the
        front; per vertex normals (n, 3), texture coordinates (n, 2) and linear colors (n, 3). Without normals faces are flat. Returns
        the number of its node."""

    def vertices(self, node: Node) -> NDArray[np.float32]:
        """(n, 3) [m], in the node's space."""

    def triangles(self, node: Node) -> NDArray[np.int64]:
        """(m, 3)."""

    def set_vertices(self, node: Node, vertices: ArrayLike, normals: ArrayLike | None = None) -> None:
        """Moves all vertices of a mesh. Flat faces stay flat; a mesh with smooth normals needs those of the moved vertices."""

    def copy(self) -> Scene: ...

class Renderer:
    """A graphics adapter, with what was drawn last on it. Threads that share one take turns. A picture does not depend on what was drawn
    before. It cannot be pickled, and does not survive a fork: make one in each process."""

    def __init__(self, adapter: str | None = None) -> None:
        """On the fastest adapter, or the one whose name or backend holds ``adapter``. Without a graphics processor a software driver
        serves (Debian: mesa-vulkan-drivers)."""

    @property
    def adapter(self) -> dict[str, Any]:
        """Its name, backend, kind, driver and limits, and the ``reason`` why it was taken."""

    @overload
    def render(
        self,
        scene: Scene,
        camera: Camera | str | None = None,
        environment: Environment | None = None,
        size: Size | None = None,
        *,
        layers: None = None,
        **options: Any,
    ) -> Radiance:
        """The picture that ``gnomon render`` makes, bit by bit. A camera is one, the name of the scene's, or a text; without one it is
        the scene's first, or one that frames the models. Without an environment it is that of the scene's file. While it draws, other
        threads go on."""

    @overload
    def render(
        self,
        scene: Scene,
        camera: Camera | str | None = None,
        environment: Environment | None = None,
        size: Size | None = None,
        *,
        layers: list[str],
        **options: Any,
    ) -> Layers:
        """The same with layers."""

    @overload
    def render_batch(
        self,
        scenes: Scene | list[Scene],
        cameras: Camera | str | None | list[Camera | str] = None,
        environments: Environment | None | list[Environment] = None,
        size: Size | None = None,
        *,
        layers: None = None,
        progress: Progress | None = None,
        **options: Any,
    ) -> NDArray[np.float32]:
        """Several pictures, (n, height, width, 3). Each argument is one for all or a list of n. Scenes that are copies of one another
        share their meshes on the device, and pictures under one environment its lights: order them so."""

    @overload
    def render_batch(
        self,
        scenes: Scene | list[Scene],
        cameras: Camera | str | None | list[Camera | str] = None,
        environments: Environment | None | list[Environment] = None,
        size: Size | None = None,
        *,
        layers: list[str],
        progress: Progress | None = None,
        **options: Any,
    ) -> Layers:
        """The same with layers, each (n, height, width[, channels])."""

    @property
    def lights(self) -> Lights | None:
        """Those of the last picture, before the environment's turn."""

class Dataset:
    """What a manifest describes (``crates/studio/DATASET.md``), on a graphics adapter. An item is the same wherever it is drawn."""

    def __init__(self, manifest: str | PathLike[str], adapter: str | None = None) -> None: ...
    def __len__(self) -> int: ...
    def draw(self, item: int) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        """Arrays of an item, ``radiance`` and the manifest's layers, and what is known beside them: camera, lights, boxes."""

    def write(
        self,
        output: str | PathLike[str],
        first: int = 0,
        last: int | None = None,
        *,
        shards: int | None = None,
        overwrite: bool = False,
        progress: Progress | None = None,
    ) -> list[tuple[int, str]]:
        """Draws the items from ``first`` to ``last``, both included, that are not in the folder yet, as ``gnomon dataset`` does. Returns
        those that failed, each with its sentence."""

def adapters() -> list[dict[str, Any]]:
    """All adapters, those that cannot draw included."""

def fit(environment: Environment, *, ground: bool = True, **options: Any) -> Lights:
    """Lights for an environment as it is turned, as ``gnomon decompose`` finds them; for scenes on a ground or not."""

@overload
def reference(
    scene: Scene,
    camera: Camera | str | None = None,
    environment: Environment | None = None,
    size: Size | None = None,
    *,
    samples: int = 256,
    seed: int = 0,
    variance: Literal[False] = False,
    progress: Progress | None = None,
    **options: Any,
) -> Radiance:
    """Ray-traces the truth on all cores: ``samples`` a pixel, the same for the same ``seed``. Ctrl-C stops it."""

@overload
def reference(
    scene: Scene,
    camera: Camera | str | None = None,
    environment: Environment | None = None,
    size: Size | None = None,
    *,
    samples: int = 256,
    seed: int = 0,
    variance: Literal[True],
    progress: Progress | None = None,
    **options: Any,
) -> tuple[Radiance, Radiance]:
    """The same with the variance of every pixel's mean."""

def check(
    radiance: ArrayLike,
    scene: Scene,
    camera: Camera | str | None = None,
    environment: Environment | None = None,
    *,
    pixels: int = 256,
    **options: Any,
) -> dict[str, float]:
    """How far a picture is from the truth: ``relative_rmse`` and its ``uncertainty``, by so many pixels that are ray-traced."""

def compare(picture: ArrayLike, reference: ArrayLike, mask: ArrayLike | None = None) -> dict[str, Any]:
    """Relative errors, PSNR and FLIP, as ``gnomon compare`` prints them; of the pixels where ``mask`` (height, width) is true."""

def read(path: str | PathLike[str]) -> Radiance:
    """A picture of any format that Gnomon reads; PNG and JPEG as linear values."""

def write(path: str | PathLike[str], radiance: ArrayLike, exposure: float = 0.0, tone_mapping: str = "neutral") -> None:
    """Writes a picture, whole or not at all: .exr and .hdr as it is, .png exposed by so many stops and tone-mapped."""

def tone_map(radiance: ArrayLike, exposure: float = 0.0, tone_mapping: str = "neutral") -> NDArray[np.uint8]:
    """What a display shows: (height, width, 3), sRGB."""

def png(radiance: ArrayLike, exposure: float = 0.0, tone_mapping: str = "neutral") -> bytes:
    """The same as a PNG file."""

class show:
    """A picture that a notebook displays."""

    def __init__(self, radiance: ArrayLike, exposure: float = 0.0, tone_mapping: str = "neutral") -> None: ...
