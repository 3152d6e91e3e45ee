"""Write assemblies and models with the real COMPAS packages into a directory (default: tests/data/compas).

    python make_files.py [DIRECTORY]

with a Python that has compas, compas_assembly, compas_model and compas_dem. Next to each file goes what those packages
read from it (see `describe.py`), so that the answers in `*.expected.json` are theirs.
"""

import json
import sys
from math import pi
from pathlib import Path

from compas.datastructures import Mesh
from compas.geometry import Box, Frame, Rotation, Translation
from compas_assembly.algorithms import assembly_interfaces
from compas_assembly.datastructures import Assembly, Block
from compas_dem.elements import Block as Element
from compas_dem.material import Stone
from compas_dem.models import BlockModel
from compas_dem.templates import ArchTemplate
from compas_model.elements import Group
from compas_model.models import Model
from describe import describe

import compas


def named(mesh, name):
    mesh.name = name
    return mesh


def block(size, point, name=None):
    mesh = Block.from_shape(Box(*size, frame=Frame(point, [1, 0, 0], [0, 1, 0])))
    return named(mesh, name) if name else mesh


def assembly():
    """A name with a space, one of another alphabet, interfaces, a density."""
    made = Assembly(name="three blocks")
    made.add_block(block((4, 4, 1), [0, 0, -0.5], "the ground"), is_support=True)
    made.add_block(block((1, 1, 1), [0, 0, 0.5], "камень/1"))
    made.add_block(block((1, 1, 0.5), [0.25, 0, 1.25], "top"), density=1800.0)
    assembly_interfaces(made)
    return made


def bare_assembly():
    """Blocks without names, one a tetrahedron whose vertices do not count from zero and whose node is no number."""
    made = Assembly()
    made.add_block(Block.from_vertices_and_faces(*block((2, 2, 1), [0, 0, -0.5]).to_vertices_and_faces()))
    tetrahedron = Block()
    for key, point in enumerate([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]):
        tetrahedron.add_vertex(key=10 * key + 3, x=point[0], y=point[1], z=point[2])
    for face in [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]:
        tetrahedron.add_face([10 * key + 3 for key in face])
    made.add_block(tetrahedron, node="tip")
    made.set_boundary_condition(0)
    return made


def model():
    """Groups in groups, transformations of the model, of a group and of an element, a material."""
    made = BlockModel(name="turned")
    made.transformation = Rotation.from_axis_and_angle([0, 0, 1], pi / 6)
    stone = Stone.from_predefined_material("LIMESTONE")
    made.add_material(stone)
    wall = made.add_group("wall")
    wall.transformation = Translation.from_vector([2, 0, 0])
    north = made.add_element(Group(name="north"), parent=wall)
    cube = Mesh.from_shape(Box(1, 1, 1))
    made.add_element(Element.from_mesh(cube, name="base", is_support=True), parent=wall)
    tilt = Translation.from_vector([0, 0, 1]) * Rotation.from_axis_and_angle([0, 0, 1], pi / 4)
    made.add_element(Element.from_mesh(cube, name="top", transformation=tilt), parent=north, material=stone)
    return made


def plain_model():
    """A model of compas_model itself that holds the voussoirs of an arch, the outer ones supports."""
    made = Model(name="arch")
    voussoirs = ArchTemplate(rise=1, span=2, thickness=0.3, depth=0.5, n=4).blocks()
    for number, mesh in enumerate(voussoirs):
        made.add_element(Element.from_mesh(mesh, name=f"voussoir {number}", is_support=number in (0, 3)))
    return made


MAKERS = {"assembly": assembly, "bare_assembly": bare_assembly, "model": model, "plain_model": plain_model}


def main(directory):
    for name, make in MAKERS.items():
        path = directory / f"{name}.json"
        compas.json_dump(make(), path)
        (directory / f"{name}.expected.json").write_text(json.dumps(describe(path)))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "data" / "compas")
