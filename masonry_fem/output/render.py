"""Render: a scene of surfaces, lines and arrows to an image, without a screen.

    if can_render():
        stage = Stage(View.of(points, dimension), width=1400)
        stage.surface(mesh, colour="#d8d2c4")
        image = stage.image()           # (height, width, 3) uint8

The camera is parallel and fitted exactly, so that ``stage.scale`` pixels are one metre (of a line
in the plane of the picture). Needs libEGL or libOSMesa where there is no X server: VTK without
either ends in a segmentation fault, hence the check before it is touched.
"""

from __future__ import annotations

import functools
import os
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host import installation
from masonry_fem.records.remark import remark

FloatArray = NDArray[np.float64]

WINDOWS = {"EGL": "vtkEGLRenderWindow", "OSMesa": "vtkOSOpenGLRenderWindow"}  # VTK's, by library
LOWEST, HIGHEST = 360, 1150  # pixels of an image's height
MARGIN = 1.04
THICK_FROM = 70  # pixels of a block's size from which its lines have their full width
# two lights (right, up, near) from the eye; VTK's own have highlights, too, whose powers are most of the work
LIGHT = """
  float lit = 0.97 * max(0.0, dot(normalVCVSOutput, normalize(vec3(0.15, 0.71, 0.69))))
            + 0.42 * max(0.0, dot(normalVCVSOutput, normalize(vec3(-0.20, -0.90, 0.38))));
  gl_FragData[0] = vec4(ambientColor + lit * diffuseColor, opacity);
"""
FINE = 2  # the image is drawn this many times finer and averaged: smooth edges on any driver


@functools.cache
def can_render() -> bool:
    """Whether pictures can be drawn here; if not, a warning says what to install."""
    if lack := installation.why_no_pictures():
        remark(
            "no_pictures",
            f"{lack}, or set output.pictures = false",
        )
        return False
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        # VTK would try an X server first and complain on stderr that there is none
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", WINDOWS[installation.renderers()[0]])
    return True


@dataclass(frozen=True, slots=True)
class View:
    """Parallel projection fitted to what it shows.

    Attributes
    ----------
    centre : Middle of the picture [m], shape (3,).
    axes : Unit vectors to the right, up and towards the eye, rows, shape (3, 3).
    half : Half width and half height of what is shown [m].
    depth : Its extent along the line of sight [m].
    """

    centre: FloatArray
    axes: FloatArray
    half: tuple[float, float]
    depth: float

    @classmethod
    def of(cls, points: FloatArray, dimension: int) -> View:
        """From the front in 2D; in 3D from the front, a little to the left and above, z upwards."""
        towards = np.array([0.0, 0.0, 1.0]) if dimension == 2 else np.array([-0.62, -1.0, 0.52])
        up = np.array([0.0, 1.0, 0.0]) if dimension == 2 else np.array([0.0, 0.0, 1.0])
        return cls.along(points, towards / np.linalg.norm(towards), up)

    @classmethod
    def along(cls, points: FloatArray, towards: FloatArray, up: FloatArray) -> View:
        """From where the unit vector ``towards`` points; ``up`` is not parallel to it."""
        right = np.cross(up, towards)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(towards, right), towards])
        seen = points @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        half = np.maximum(0.5 * (high - low), 1e-3 * np.linalg.norm(high - low) + 1e-12)
        centre = axes.T @ (0.5 * (low + high))
        return cls(centre, axes, (float(half[0]), float(half[1])), float(high[2] - low[2]))

    @property
    def flat(self) -> bool:
        """Whether it shows a plane structure from the front."""
        return bool(abs(self.axes[2, 2]) > 0.999)


class Stage:
    """A picture in the making.

    Attributes
    ----------
    size : Width and height of the image [pixels].
    scale : Pixels a metre.
    """

    def __init__(self, view: View, width: int, block: float = np.inf) -> None:
        """Prepare a stage ``width`` pixels wide; lines become thin where a ``block`` [m] is small."""
        half_width, half_height = view.half
        height = int(np.clip(width * half_height / half_width, LOWEST, HIGHEST))
        self.view, self.size = view, (width, height)
        self.scale = min(width / (2 * MARGIN * half_width), height / (2 * MARGIN * half_height))
        self._lift = 2.0 / self.scale  # lines stand two pixels' length before their surface
        self._pen = FINE * float(np.clip(block * self.scale / THICK_FROM, 0.3, 1.0))
        self.plotter: Any = _plotter()
        self.plotter.clear_actors()
        self.plotter.window_size = [FINE * width, FINE * height]

    def surface(self, mesh: Any, **options: Any) -> None:
        """Add faces, flat-lit in 2D; options as of pyvista's ``add_mesh``."""
        defaults = {"show_scalar_bar": False, "ambient": 0.62, "diffuse": 0.42, "line_width": FINE}
        self._lit(mesh, **(defaults | options))

    def _lit(self, mesh: Any, **options: Any) -> None:
        """Add a mesh that is lit, but in 2D."""
        look = {"lighting": not self.view.flat} | options
        actor = self.plotter.add_mesh(mesh, **look)
        if look["lighting"]:
            actor.GetShaderProperty().AddFragmentShaderReplacement("//VTK::Light::Impl", True, LIGHT, False)

    def lines(self, mesh: Any, colour: str, width: float, *, rank: int = 1, opacity: float = 1.0) -> None:
        """Add lines, a little nearer to the eye than what they lie on; a higher rank lies over a lower."""
        if mesh.n_points:
            lifted = mesh.translate(self.view.axes[2] * self._lift * rank, inplace=False)
            self.plotter.add_mesh(
                lifted, color=colour, line_width=self._pen * width, lighting=False, opacity=opacity
            )

    def solid(self, mesh: Any, colour: str, *, rank: int = 3) -> None:
        """Add coloured bodies (arrows, bars) over everything else: inside blocks they would not be seen."""
        if mesh.n_points:
            # along the line of sight nothing changes its place in a parallel projection
            lift = 2.2 * self.view.depth + self._lift * rank
            lifted = mesh.translate(self.view.axes[2] * lift, inplace=False)
            self._lit(lifted, color=colour, ambient=0.55, diffuse=0.5)

    def mark(self, mesh: Any, colour: str | None = None, *, rank: int = 3, **options: Any) -> None:
        """Add flat figures over everything else, in their own colour whatever the light."""
        if mesh.n_points:
            lift = 2.2 * self.view.depth + self._lift * rank
            lifted = mesh.translate(self.view.axes[2] * lift, inplace=False)
            look = {"show_scalar_bar": False, "lighting": False} | ({"color": colour} if colour else {})
            self.plotter.add_mesh(lifted, **(look | options))

    def image(self) -> NDArray[np.uint8]:
        """Draw and end: the stage is empty afterwards."""
        from PIL import Image  # noqa: PLC0415

        camera, view = self.plotter.camera, self.view
        reach = 4.0 * (float(np.hypot(*view.half)) + view.depth)
        camera.focal_point = view.centre
        camera.position = view.centre + reach * view.axes[2]
        camera.up = view.axes[1]
        camera.parallel_projection = True
        camera.parallel_scale = self.size[1] / (2 * self.scale)
        self.plotter.camera_set = True
        self.plotter.renderer.reset_camera_clipping_range()
        fine = _drawn(self.plotter.render_window)
        self.plotter.clear_actors()
        height, width, _ = fine.shape
        # four bytes a pixel are Pillow's own form: nothing is copied before the image is small
        coarse = Image.frombuffer("RGBX", (width, height), fine, "raw", "RGBX", 0, 1).reduce(FINE)
        return np.asarray(coarse.transpose(Image.Transpose.FLIP_TOP_BOTTOM).convert("RGB"))


def _drawn(window: Any) -> NDArray[np.uint8]:
    """Draw a window: red, green, blue and alpha of its pixels, rows from below, shape (height, width, 4)."""
    from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: PLC0415 - VTK is slow to import
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray  # noqa: PLC0415 - VTK is slow to import

    window.Render()
    data, front = vtkUnsignedCharArray(), 1
    width, height = window.GetSize()
    window.GetRGBACharPixelData(0, 0, width - 1, height - 1, front, data)
    pixels: NDArray[np.uint8] = vtk_to_numpy(data).reshape(height, width, 4)
    return pixels


@functools.cache
def _plotter() -> Any:
    """The one that draws all images: a new one each compiles its shaders again."""
    can_render()  # chooses VTK's window, which is fixed when it is first loaded
    import pyvista as pv  # noqa: PLC0415  only where pictures are drawn

    plotter = pv.Plotter(off_screen=True, lighting="none")
    plotter.add_light(pv.Light(light_type="headlight"))  # without any, VTK's shaders have no normals
    plotter.set_background("white")
    plotter.disable_anti_aliasing()  # the finer image is what smooths edges
    plotter.suppress_rendering = True
    plotter.renderer.UseOITOff()  # glass of one colour looks the same in any order, for half the time
    return plotter
