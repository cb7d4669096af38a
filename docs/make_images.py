"""Make docs/images from the demos: ``python docs/make_images.py [NAME ...]``.

Without a name all of them, and those of the joint laws: six minutes. The picture of the wall that cracks has
the curves of the tests only where the folder that MASONRY_FEM_SHARED names holds them.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path

from PIL import Image, ImageChops

from masonry_fem import load, study
from masonry_fem.analyses.collapse import collapse
from masonry_fem.analyses.refine import refine
from masonry_fem.analyses.threshold import threshold
from masonry_fem.output.exporting import export
from masonry_fem.output.view import showing_of
from masonry_fem.output.viewing.look import Look
from masonry_fem.output.viewing.recorded import Recorded
from masonry_fem.scene import loads

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
WIDTHS = (1600, 1400, 1200, 1080)  # pixels
HEAVY = 250_000  # bytes
# demo -> what its main() takes, and image of the docs -> picture of the demo
DEMOS: dict[str, tuple[dict[str, object], dict[str, str]]] = {
    "slope": ({}, {"slope": "deformed"}),
    "bouncing": ({}, {"bouncing": "bouncing"}),
    "low_wall": ({}, {"low_wall": "von_mises", "low_wall_ground": "ground"}),
    "arch": (
        {"divisions": (8, 4, 12)},
        {
            "arch": "overview",
            "arch_principal_stresses": "principal_stresses",
            "arch_reactions": "reactions",
            "arch_thrust": "thrust",
            "arch_utilisation": "utilisation",
            "arch_deformed": "deformed",
            "arch_resultants": "resultants",
            "arch_opening": "opening",
            "arch_cut": "cut_middle_von_mises",
        },
    ),
    "arch_inset": ({}, {"arch_inset": "arch_inset"}),
    "arch_bridge": (
        {"variants": ("elastic", "rigid")},
        {
            "arch_bridge": "arch_bridge",
            "arch_bridge_deformed": "rigid/deformed",
            "arch_bridge_plastic": "elastic/stone_plastic_strain",
        },
    ),
    "struck_arch": (
        {},
        {
            "struck_arch_built": "built/thrust",
            "struck_arch": "struck/thrust",
            "struck_arch_spread": "spread/thrust",
        },
    ),
    "shaken_column": ({}, {"shaken_column": "response"}),
    "shaken_facade": (
        {},
        {
            "shaken_facade": "deformed",
            "shaken_facade_fallen": "fallen",
            "shaken_facade_response": "response",
        },
    ),
    "built_wall": ({}, {"built_wall": "settled/overview"}),
    "crossed_bridge": (
        {},
        {"crossed_bridge": "worst/overview", "crossed_bridge_places": "places"},
    ),
    "chained_dome": ({}, {"chained_dome": "resultants"}),
    "tied_arch": ({}, {"tied_arch": "overview", "tied_arch_thrust": "thrust"}),
    "dome": ({}, {"dome": "deformed"}),
    "dome_section": ({}, {"dome_section": "von_mises", "dome_section_cut": "cut_meridian_von_mises"}),
    "dome_on_piers": ({}, {"dome_on_piers_dry": "dry/deformed", "dome_on_piers": "overview"}),
    "flying_buttresses": (
        {},
        {
            "flying_buttresses": "overview",
            "flying_buttresses_thrust": "thrust",
            "flying_buttresses_alone": "alone/deformed",
        },
    ),
    "floor_rotation": ({}, {"floor_rotation": "deformed"}),
    "settlement": ({}, {"settlement": "deformed", "settlement_thrust": "thrust"}),
    "portal_study": ({}, {"portal_study": "pareto"}),
    "keystone": ({}, {"keystone": "overview"}),
    "window_bay": ({}, {"window_bay": "von_mises", "window_bay_resultants": "resultants"}),
    "cyclic_joint": ({}, {"cyclic_joint": "cyclic_joint"}),
    "shear_wall": ({}, {"shear_wall": "shear_wall", "shear_wall_cracked": "fine/overview"}),
    "tower": ({}, {"tower": "von_mises", "tower_cut": "cut_front_vertical"}),
    "rubble_wall": ({}, {"rubble_wall": "falls/deformed", "rubble_wall_tilted": "tilted/deformed"}),
    "spreading_arch": ({}, {"spreading_arch": "overview", "spreading_arch_mechanism": "mechanism"}),
    "rocking_column": ({}, {"rocking_column": "rocking_column"}),
    "dry_walls": ({}, {"dry_walls": "dry_walls"}),
    "cracking_wall": (
        {},
        {
            "cracking_wall": "SW.100/wall",
            "cracking_wall_damage": "SW.100/stone_damage",
            "cracking_wall_30": "SW.30/wall",
        },
    ),
    "split_stone": ({}, {"split_stone": "stone_damage"}),
    "crushed_pillar": ({}, {"crushed_pillar": "stone_plastic_strain"}),
}


def make(name: str) -> None:
    """Run a demo and keep its pictures, small."""
    settings, pictures = DEMOS[name]
    with tempfile.TemporaryDirectory() as folder:
        import_module(f"demos.{name}").main(out=Path(folder), **settings)
        for image, picture in pictures.items():
            size = shrink(Path(folder) / f"{picture}.png", IMAGES / f"{image}.png")
            print(f"{image}.png  {size / 1e3:.0f} kB")


def make_elastic_floors() -> None:
    """The demo of the floor that turns, with elastic stones."""
    with tempfile.TemporaryDirectory() as folder:
        import_module("demos.floor_rotation").main(out=Path(folder), fidelity="elastic")
        size = shrink(Path(folder) / "overview.png", IMAGES / "floor_rotation_elastic.png")
    print(f"floor_rotation_elastic.png  {size / 1e3:.0f} kB")


def make_mechanism() -> None:
    """The mechanism of docs/collapse.md: an arch under a growing acceleration."""
    changes = ["title='Arch under a growing acceleration'", "joints.0.inset=1.0"]
    changes += ["structures.arch.thickness=0.2"]
    found = collapse(load(ROOT / "demos" / "arch_inset.toml", changes), acceleration="x")
    with tempfile.TemporaryDirectory() as folder:
        found.write(Path(folder))
        size = shrink(Path(folder) / "mechanism.png", IMAGES / "mechanism.png")
    print(f"mechanism.png  {size / 1e3:.0f} kB")


def make_threshold() -> None:
    """The mechanism of docs/thresholds.md: an arch whose springings part."""
    changes = [
        "title='Arch on springings that part'",
        "fidelity=rigid",
        "joints.0.placement=corners",
        "supports=[{on='arch.springing_right', motion={displacement=[0.3, 0.0]}}]",
    ]
    with tempfile.TemporaryDirectory() as folder:
        found = threshold(
            ROOT / "demos" / "spreading_arch.toml",
            "supports.0.motion.displacement",
            (0.2, 0.5),
            along=(1.0, 0.0),
            overrides=changes,
            limit=False,
            out=folder,
        )
        found.write()
        size = shrink(Path(folder) / "mechanism.png", IMAGES / "threshold.png")
    print(f"threshold.png  {size / 1e3:.0f} kB")


def make_study() -> None:
    """The picture of docs/study.md: the arch with meshes, tolerances and fidelities."""
    with tempfile.TemporaryDirectory() as folder:
        made = study(
            ROOT / "demos" / "arch.toml",
            {
                "mesh.divisions": [[1, 1, 2], [2, 1, 4], [4, 2, 8], [8, 4, 16]],
                "solver.tolerance": [1e-3, 1e-9],
                "fidelity": ["rigid", "elastic"],
            },
            quantities=["thrust", "probes", "stress.means", "stress.p95"],
            out=Path(folder),
        )
        *_, picture = made.write()
        size = shrink(picture, IMAGES / "study.png")
    print(f"study.png  {size / 1e3:.0f} kB")


def make_cracking_study() -> None:
    """The picture of docs/strength.md: the peak of a wall by the tensile strength of its stones."""
    with tempfile.TemporaryDirectory() as folder:
        made = study(
            ROOT / "demos" / "cracking_wall.toml",
            {"materials.sandstone.inelastic.tensile_strength": ["3 MPa", "4 MPa", "6 MPa"]},
            overrides=("analysis.load_steps=20", "supports.0.motion.displacement=[8e-3,0.0]"),
            quantities=["peak"],
            peaks=["supports.jack.x"],
            out=Path(folder),
        )
        *_, picture = made.write()
        size = shrink(picture, IMAGES / "cracking_wall_study.png", (572,))
    print(f"cracking_wall_study.png  {size / 1e3:.0f} kB")


def make_reduced() -> None:
    """The picture of docs/reduced.md: a wall that is pushed, of rigid, reduced and elastic stones."""
    scene = loads(
        """
        title = "Wall pushed aside, 6 steps of 10 ms"
        mesh = { divisions = [4, 2, 2] }
        materials.stone = { young = "10 GPa", density = "2400 kg/m^3" }
        joints = [{ friction = 0.6 }]
        loads.gravity = [0.5, 0.0, -9.81]
        analysis = { kind = "dynamics", step = "10 ms", duration = "60 ms", theta = 1.0 }
        [[structures]]
        kind = "wall"
        name = "wall"
        material = "stone"
        brick = [0.5, 0.25, 0.25]
        columns = 10
        courses = 10
        """
    )
    with tempfile.TemporaryDirectory() as folder:
        made = study(
            scene,
            {"fidelity": ["rigid", "reduced", "elastic"], "materials.stone.degree": [1, 2]},
            quantities=["stress.means", "stress.p95"],
            out=Path(folder),
        )
        *_, picture = made.write()
        size = shrink(picture, IMAGES / "reduced.png")
    print(f"reduced.png  {size / 1e3:.0f} kB")


def make_refined() -> None:
    """The picture of docs/errors.md: a plane wall with a load on one brick, refined to 8 %."""
    scene = loads(
        """
        title = "Wall with a load on one brick, refined to 8 %"
        dimension = 2
        plane = "stress"
        mesh = { size = 0.125 }
        materials.stone = { young = "10 GPa", density = "2400 kg/m^3" }
        joints = [{ friction = 0.6 }]
        loads.gravity = [0.0, -9.81]
        loads.tractions = [{ on = "wall.c6.b3/top", vector = [0.0, -2e6] }]
        output = { fields = false }
        [[structures]]
        kind = "wall"
        name = "wall"
        material = "stone"
        brick = [0.5, 0.25]
        columns = 6
        courses = 6
        """
    )
    with tempfile.TemporaryDirectory() as folder:
        refine(scene, Path(folder), target=0.08)
        size = shrink(Path(folder) / "stress_error.png", IMAGES / "refined.png")
    print(f"refined.png  {size / 1e3:.0f} kB")


def make_side_by_side() -> None:
    """Pictures of docs/side_by_side.md that no run writes: the arch pulled apart, its names, its report."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        import_module("demos.arch").main(out=folder / "arch")
        export(folder / "arch", folder / "arch.vtm")
        pull_apart(folder / "arch", folder / "apart.png")
        name_stones(folder / "arch.vtm", folder / "names.png")
        made = ["apart", "names"]
        if browser := shutil.which("chromium") or shutil.which("google-chrome"):
            photograph(browser, folder / "arch" / "report.html", folder / "report.png")
            made.append("report")
        for picture in made:
            trim(folder / f"{picture}.png")
            size = shrink(folder / f"{picture}.png", IMAGES / f"arch_{picture}.png", WIDTHS[-1:])
            print(f"arch_{picture}.png  {size / 1e3:.0f} kB")


def pull_apart(results: Path, picture: Path) -> None:
    """What ``masonry-fem view --apart 0.3 --field utilisation`` shows."""
    showing = showing_of(Recorded.of(results), Look("utilisation", 0.0, apart=0.3))
    showing.plotter.screenshot(picture, window_size=[1280, 800])


def name_stones(file: Path, picture: Path) -> None:
    """A multi-block file as VTK's reader gives it to ParaView: names of parts, fields at their points."""
    import pyvista as pv  # noqa: PLC0415 - after the run, which chooses VTK's window

    parts = pv.read(file)
    plotter = pv.Plotter(off_screen=True, window_size=[1280, 800])
    plotter.set_background("white")
    places, names = [], []
    for name, part in zip(parts.keys(), parts, strict=True):
        known = "von_mises" in part.point_data
        plotter.add_mesh(
            part, scalars="von_mises" if known else None, color=None if known else "#a9adb2", clim=[0, 8e4],
            cmap="viridis", scalar_bar_args={"title": "von_mises", "color": "black", "vertical": True},
        )  # fmt: skip
        plotter.add_mesh(part.extract_feature_edges(25.0), color="#33383f", line_width=2)
        places.append(part.center)
        names.append(name)
    plotter.add_point_labels(
        places,
        names,
        font_size=18,
        shape_opacity=0.75,
        shape_color="white",
        always_visible=True,
        point_size=1,
    )
    plotter.view_vector((-0.3, -1.0, 0.3), (0.0, 0.0, 1.0))
    plotter.screenshot(picture)


def photograph(browser: str, page: Path, picture: Path) -> None:
    """The top of a page in a browser without a window."""
    subprocess.run(
        [browser, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
         "--hide-scrollbars", "--enable-unsafe-swiftshader", "--virtual-time-budget=5000",
         "--window-size=1080,1250",
         f"--user-data-dir={page.parent / 'profile'}", f"--screenshot={picture}", f"file://{page}"],
        check=True, capture_output=True, timeout=300,
    )  # fmt: skip


def trim(picture: Path) -> None:
    """Take the white around a picture away, but for a margin."""
    image = Image.open(picture).convert("RGB")
    left, top, right, bottom = ImageChops.invert(image).getbbox() or (0, 0, *image.size)
    edge = (max(left - 16, 0), max(top - 16, 0), right + 16, bottom + 16)
    image.crop((*edge[:2], *map(min, edge[2:], image.size))).save(picture)


def shrink(source: Path, target: Path, widths: tuple[int, ...] = WIDTHS) -> int:
    """Copy a picture at the greatest width that keeps it light; returns its size [bytes].

    Parameters
    ----------
    source, target : Files. widths : That are tried [pixels].
    """
    picture = Image.open(source).convert("RGB")
    target.parent.mkdir(parents=True, exist_ok=True)
    for width in widths:
        if width <= picture.width or width == widths[-1]:
            height = round(picture.height * width / picture.width)
            picture.resize((width, height), Image.Resampling.LANCZOS).save(target, optimize=True)
            if target.stat().st_size <= HEAVY:
                return target.stat().st_size
    # The colours of a bar are few pixels each: by their number, as is usual, they would be merged. Each then
    # goes to the mean of its pixels (k-means), else the greys of glass become pink and green.
    few = Image.open(target).quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    few.save(target, optimize=True)
    return target.stat().st_size


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    others = {
        "elastic_floors": make_elastic_floors,
        "mechanism": make_mechanism,
        "threshold": make_threshold,
        "study": make_study,
        "refined": make_refined,
        "cracking_study": make_cracking_study,
        "reduced": make_reduced,
        "side_by_side": make_side_by_side,
    }
    for demo in sys.argv[1:] or (*DEMOS, *others):
        if demo in others:
            others[demo]()
        else:
            make(demo)
    if not sys.argv[1:]:
        subprocess.run([sys.executable, ROOT / "docs" / "make_law_images.py"], check=True)
