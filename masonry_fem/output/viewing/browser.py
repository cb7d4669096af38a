"""Browser: the same controls as the window's in a page, drawn here and sent as pictures, by trame.

It needs no screen on the machine that draws: over ssh, forward the port and open the page at home.
"""

from __future__ import annotations

from typing import Any

from masonry_fem.output.viewing.showing import Showing
from masonry_fem.output.viewing.window import plane_at

NOWHERE = "none"


def page_of(showing: Showing) -> Any:
    """A trame server with the page, not yet started.

    Parameters
    ----------
    showing : What is shown; its plotter draws off screen.
    """
    from trame.app import get_server  # noqa: PLC0415
    from trame.ui.vuetify3 import SinglePageLayout  # noqa: PLC0415
    from trame.widgets import html, vtk, vuetify3  # noqa: PLC0415

    server = get_server("masonry_fem", client_type="vue3")
    state, plotter = server.state, showing.plotter
    count = len(showing.recorded.files)
    state.update({
        "step": showing.place + 1, "field": showing.look.field, "factor": showing.look.factor,
        "axis": NOWHERE if showing.look.section is None else "xyz"[showing.look.section.axis],
        "share": 0.5, "told": "Click on a block.", "caption": showing.caption(),
    })  # fmt: skip
    if showing.look.section is not None:
        state.share = _share(showing)

    def clicked(x: float, y: float) -> None:
        state.told = showing.pick(x, y) or "No block there."
        server.controller.view_update()

    with SinglePageLayout(server) as page:
        page.title.set_text(showing.recorded.title)
        page.icon.hide()
        with page.toolbar:
            vuetify3.VSpacer()
            vuetify3.VSelect(v_model=("field",), items=("fields", showing.fields), label="field", **_TIGHT)
            if count > 1:
                vuetify3.VSlider(v_model=("step",), min=1, max=count, step=1, label="step", **_TIGHT)
            most = 4.0 * max(showing.look.factor, 1.0)
            vuetify3.VSlider(
                v_model=("factor",), min=0, max=most, step=most / 100, label="amplification", **_TIGHT
            )
            vuetify3.VSelect(v_model=("axis",), items=("axes", [NOWHERE, *"xyz"]), label="section", **_TIGHT)
            vuetify3.VSlider(v_model=("share",), min=0, max=1, step=0.01, **_TIGHT)
        with page.content, html.Div(style="position: relative; width: 100%; height: 100%;"):
            view = vtk.VtkRemoteView(
                plotter.render_window, interactor_events=("events", ["LeftButtonPress"]),
                LeftButtonPress=(clicked, "[$event.position.x, $event.position.y]"),
            )  # fmt: skip
            server.controller.view_update = view.update
            html.Pre("{{ told }}", style="position: absolute; left: 12px; bottom: 12px; margin: 0")

    @state.change("step", "field", "factor", "axis", "share")
    def changed(**_: Any) -> None:
        if int(state.step) - 1 != showing.place:
            showing.step(int(state.step) - 1)
        if state.field != showing.look.field:
            showing.field(state.field)
        if float(state.factor) != showing.look.factor:
            showing.factor(float(state.factor))
        axis = state.axis
        plane = None if axis == NOWHERE else plane_at(showing, "xyz".index(axis), float(state.share))
        if plane != showing.look.section:
            showing.section(plane)
        view.update()

    return server


_TIGHT: dict[str, Any] = {
    "density": "compact", "hide_details": True, "style": "max-width: 220px", "class": "mx-2"
}  # fmt: skip


def _share(showing: Showing) -> float:
    """Where the section plane stands between the ends of the structure."""
    section = showing.look.section
    assert section is not None
    points = showing.recorded.blocks(showing.place).points[:, section.axis]
    return float((section.at - points.min()) / max(float(points.max() - points.min()), 1e-300))


def open_page(showing: Showing, port: int) -> None:
    """Serve the page until Ctrl-C.

    Parameters
    ----------
    showing : What is shown. port : Of this machine; 0 for a free one.
    """
    page_of(showing).start(port=port, open_browser=port == 0, show_connection_info=True)
