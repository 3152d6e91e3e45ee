"""What the real COMPAS packages read from a file: `python describe.py FILE.json` prints it as JSON."""

import json
import sys

import compas


def describe(path):
    """Name, and of each block its name, group, support, density, vertices, faces and volume, in model coordinates."""
    made = compas.json_load(str(path))
    rows = _of_assembly(made) if hasattr(made, "node_block") else _of_model(made)
    return {"name": made.attributes.get("name", made.name), "dtype": made.__dtype__, "blocks": rows}


def _of_assembly(made):
    rows = []
    for node in made.graph.nodes():
        block = made.node_block(node)
        group, density = block.attributes.get("group", ""), block.attributes.get("density")
        density = made.graph.node_attribute(node, "density") or density
        support = bool(made.graph.node_attribute(node, "is_support"))
        rows.append(_row(block._name or str(node), group, support, density, block))
    return rows


def _of_model(made):
    rows = []
    for element in made.elements():
        if type(element).__name__ == "Group":
            continue
        groups, parent = [], element.parent
        while parent:
            groups.insert(0, parent.name)
            parent = parent.parent
        density = element.material.density if element.material else None
        rows.append(_row(element.name, ".".join(groups), element.is_support, density, element.modelgeometry))
    return rows


def _row(name, group, support, density, mesh):
    vertices, faces = mesh.to_vertices_and_faces()
    row = {"name": name, "group": group, "support": support, "density": density}
    return row | {"vertices": vertices, "faces": faces, "volume": mesh.volume()}


if __name__ == "__main__":
    print(json.dumps(describe(sys.argv[1])))
