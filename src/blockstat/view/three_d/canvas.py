"""An assembly in a viser scene: a few meshes, one for each colour, with the edges of the blocks and arrows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.typing import Floats, Ints
from blockstat.view.three_d.geometry import surface

if TYPE_CHECKING:
    import viser

    from blockstat.assembly import Assembly
    from blockstat.view.three_d.colouring import Colouring

EDGE, FAINT_EDGE = (60, 60, 60), (190, 190, 190)
CHOSEN = (0, 0, 0)
CONTACT = (0, 114, 178)  #: the blue of contacts without area, as in `blockstat.view.plot`
#: Half the angle of view, vertically, and where the eye is when a view opens: from the south-west, above.
HALF_VIEW = np.deg2rad(25.0)
AMBIENT = 2.2
LIGHTS = (((-0.5, -0.3, 1.0), 1.1), ((0.2, -1.0, 0.2), 0.6))
EYE = np.array([-0.62, -0.95, 0.62])
#: Width over height of a picture whose shape is not known yet, and the room left around the building.
UPRIGHT, MARGIN = 0.8, 1.06


class Canvas:
    """Draws on a viser server; what was drawn before is replaced.

    Coordinates are sent relative to the middle of the first assembly drawn after `recentre`, so that a model far from
    the origin keeps its digits in the single precision of a browser.

    Parameters
    ----------
    server : viser.ViserServer
        The server.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._origin = np.zeros(3)
        self._meshes: dict[int, tuple[Any, Ints]] = {}  # handle and vertices by number of the colour
        self._edges: Any = None
        self._arrows: dict[str, Any] = {}
        self._contacts: list[Any] = []
        self._chosen: tuple[Any, Ints] | None = None  # lines and the vertices at their ends
        self._seen = np.zeros((1, 3), dtype=np.float32)  # what a view that opens must show
        self._eyes: dict[int, tuple[float, Floats]] = {}  # aspect and eye by client, as they were set last
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._left)
        server.scene.set_up_direction("+z")
        # Even light, so that a colour looks like its patch in the legend on every side of a block.
        server.scene.configure_default_lights(enabled=False)
        server.scene.configure_environment_map(None)
        server.scene.add_light_ambient("/light/everywhere", intensity=AMBIENT)
        for k, (place, strength) in enumerate(LIGHTS):
            server.scene.add_light_directional(f"/light/{k}", intensity=strength, position=place, cast_shadow=False)

    def recentre(self, assembly: Assembly) -> None:
        """Take the assembly's middle as origin and look at all of it, in open pages too.

        Parameters
        ----------
        assembly : Assembly
            The blocks to be drawn next.
        """
        free = assembly.vertices[~assembly.support[assembly.vertex_block]]
        seen = free if len(free) else assembly.vertices
        lower, upper = seen.min(axis=0), seen.max(axis=0)
        self._origin = (lower + upper) / 2
        self._seen = self._local(seen)
        self._look(self._server.initial_camera, UPRIGHT)
        for client in self._server.get_clients().values():
            self._fit(client)

    def _left(self, client: viser.ClientHandle) -> None:
        self._eyes.pop(client.client_id, None)

    def _connected(self, client: Any) -> None:
        """Show all of the building to a browser that opens, and again when its shape changes before it is turned."""
        self._fit(client)
        client.camera.on_update(lambda _: self._reshaped(client))

    def _reshaped(self, client: Any) -> None:
        aspect, eye = self._eyes.get(client.client_id, (0.0, np.zeros(3)))
        turned = np.linalg.norm(client.camera.position - eye) > 1e-3 * np.linalg.norm(eye)
        if not turned and abs(_aspect(client.camera) - aspect) > 0.01:
            self._fit(client)

    def _fit(self, client: Any) -> None:
        aspect = _aspect(client.camera)
        self._eyes[client.client_id] = aspect, self._look(client.camera, aspect)

    def _look(self, camera: Any, aspect: float) -> Floats:
        """Put a camera where it sees all of the building, and return that place."""
        eye = EYE / np.linalg.norm(EYE)
        right = np.cross([0.0, 0.0, 1.0], eye)
        right /= np.linalg.norm(right)
        wide = np.abs(self._seen @ right) / (np.tan(HALF_VIEW) * aspect)
        high = np.abs(self._seen @ np.cross(eye, right)) / np.tan(HALF_VIEW)
        distance = MARGIN * float(np.max(self._seen @ eye + np.maximum(wide, high))) or 1.0
        camera.fov = 2 * HALF_VIEW
        camera.far = 100 * distance
        camera.near = 1e-3 * distance
        camera.position = distance * eye  # before the point looked at, which viser moves along
        camera.look_at = np.zeros(3)
        return distance * eye

    def draw(
        self, assembly: Assembly, colours: Colouring, vertices: Floats | None = None, *, opacity: float = 1.0
    ) -> None:
        """Draw the blocks of an assembly in their colours.

        Parameters
        ----------
        assembly : Assembly
            The blocks.
        colours : Colouring
            A colour for every block.
        vertices : array of float, shape (n_vertices, 3), optional
            Places of the vertices instead of the assembly's own [m].
        opacity : float, optional
            Of the blocks, 0 to 1.
        """
        self.assembly, self.shape = assembly, surface(assembly)
        self.paint(colours, vertices, opacity=opacity)

    def paint(self, colours: Colouring, vertices: Floats | None = None, *, opacity: float = 1.0) -> None:
        """Draw the blocks that are there in other colours.

        Parameters
        ----------
        colours : Colouring
            A colour for every block.
        vertices : array of float, shape (n_vertices, 3), optional
            Places of the vertices instead of the assembly's own [m].
        opacity : float, optional
            Of the blocks, 0 to 1.
        """
        self.vertices = self.assembly.vertices if vertices is None else vertices
        shown = self._local(self.vertices)
        number = colours.index[self.shape.triangle_block]
        used = np.unique(number)
        with self._server.atomic():
            for k in np.setdiff1d(list(self._meshes), used):
                self._meshes.pop(int(k))[0].remove()
            for k in used:
                corners, faces = np.unique(self.shape.triangles[number == k], return_inverse=True)
                handle = self._server.scene.add_mesh_simple(
                    f"/blocks/{k}", shown[corners], faces.reshape(-1, 3).astype(np.uint32), flat_shading=True,
                    color=colours.palette[k].astype(np.uint8), cast_shadow=False, receive_shadow=False,
                    opacity=None if opacity >= 1 else opacity,
                )  # fmt: skip
                self._meshes[int(k)] = handle, corners
            self._edges = self._lines("/edges", shown[self.shape.edges], EDGE if opacity >= 1 else FAINT_EDGE, 1.0)

    def clear(self) -> None:
        """Take away all that is drawn."""
        self.hide_arrows()
        self.choose(None)
        for handle, _ in self._meshes.values():
            handle.remove()
        self._meshes = {}
        if self._edges is not None:
            self._edges.remove()
            self._edges = None

    def pose(self, vertices: Floats) -> None:
        """Move the blocks that are there.

        Parameters
        ----------
        vertices : array of float, shape (n_vertices, 3)
            Where their vertices go [m].
        """
        self.vertices = vertices
        shown = self._local(vertices)
        with self._server.atomic():
            for handle, corners in self._meshes.values():
                handle.vertices = shown[corners]
            if self._edges is not None:
                self._edges.points = shown[self.shape.edges]
            if self._chosen is not None:
                self._chosen[0].points = shown[self._chosen[1]]

    def arrows(self, name: str, tail: Floats, head: Floats, colour: tuple[int, int, int], radius: float) -> None:
        """Draw arrows under a name, in place of those drawn under it before.

        Parameters
        ----------
        name : str
            The name.
        tail, head : array of float, shape (n, 3)
            Ends of the arrows [m]; n = 0 only removes those drawn before.
        colour : tuple of int
            Red, green and blue, 0 to 255.
        radius : float
            Of the shafts [m].
        """
        before = self._arrows.pop(name, None)
        if before is not None:
            before.remove()
        if len(tail):
            points = self._local(np.stack([tail, head], axis=1))
            self._arrows[name] = self._server.scene.add_arrows(
                f"/arrows/{name}", points, colour, shaft_radius=radius, head_radius=2.5 * radius, head_length=6 * radius
            )

    def contacts(self, lines: Floats, dots: Floats, radius: float) -> None:
        """Draw contacts without area, in place of those drawn before.

        Parameters
        ----------
        lines : array of float, shape (n, 2, 3)
            Ends of the edges on faces [m].
        dots : array of float, shape (m, 3)
            Corners on faces and crossings of edges [m].
        radius : float
            Of the dots [m].
        """
        for handle in self._contacts:
            handle.remove()
        self._contacts = []
        if len(lines):
            self._contacts.append(self._lines("/contacts/edges", self._local(lines), CONTACT, 4.0))
        if len(dots):
            handle = self._server.scene.add_point_cloud(
                "/contacts/corners", self._local(dots), CONTACT, point_size=2 * radius,
                point_shape="circle", point_shading="flat", precision="float32",
            )  # fmt: skip
            self._contacts.append(handle)

    def choose(self, block: int | None) -> None:
        """Draw the edges of one block thick, through what is before them.

        Parameters
        ----------
        block : int or None
            Number of the block; None leaves no block marked.
        """
        if self._chosen is not None:
            self._chosen[0].remove()
            self._chosen = None
        if block is not None:
            own = self.shape.edges[self.shape.edge_block == block]
            self._chosen = self._lines("/chosen", self._local(self.vertices)[own], CHOSEN, 4.0), own

    def ray(self, origin: Any, direction: Any) -> tuple[Floats, Floats]:
        """Return a ray of the page in the assembly's coordinates.

        Parameters
        ----------
        origin, direction : sequence of float
            Three numbers each, as the page sends them.

        Returns
        -------
        origin : array of float, shape (3,)
            Where the ray begins [m].
        direction : array of float, shape (3,)
            Where it goes.
        """
        return np.asarray(origin, dtype=float) + self._origin, np.asarray(direction, dtype=float)

    def hide_arrows(self) -> None:
        """Take away all arrows and marks of contacts, which belong to the blocks where they are built."""
        nothing = np.empty((0, 3))
        for name in list(self._arrows):
            self.arrows(name, nothing, nothing, (0, 0, 0), 1.0)
        self.contacts(nothing, nothing, 1.0)

    def _lines(self, name: str, points: np.ndarray, colour: tuple[int, int, int], width: float) -> Any:
        return self._server.scene.add_line_segments(
            name, points, colour, thickness=width, thickness_units="screen"
        )  # fmt: skip

    def _local(self, points: Floats) -> np.ndarray:
        return (points - self._origin).astype(np.float32)


def _aspect(camera: Any) -> float:
    """Width over height of the picture of a browser."""
    return float(camera.image_width) / camera.image_height if camera.image_height else UPRIGHT
