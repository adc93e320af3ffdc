"""Everyday things as small meshes, metres, standing on z = 0 about the origin unless said otherwise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache

import numpy as np
import trimesh
from trimesh import Trimesh, creation, transformations


def block(size: Sequence[float], center: Sequence[float] = (0.0, 0.0, 0.0)) -> Trimesh:
    """Return a block about a centre."""
    return creation.box(size, transformations.translation_matrix(center))


def joined(parts: Iterable[Trimesh]) -> Trimesh:
    return trimesh.boolean.union(list(parts), engine="manifold")


def without(whole: Trimesh, *parts: Trimesh) -> Trimesh:
    return trimesh.boolean.difference([whole, *parts], engine="manifold")


def moved(mesh: Trimesh, shift: Sequence[float], yaw: float = 0.0, tilt: float = 0.0) -> Trimesh:
    """Return a mesh leaning over towards its X axis by ``tilt``, then turned by ``yaw``, and shifted."""
    mesh = mesh.copy()
    mesh.apply_transform(transformations.rotation_matrix(tilt, [0, 1, 0]))
    mesh.apply_transform(transformations.rotation_matrix(yaw, [0, 0, 1]))
    mesh.apply_translation(shift)
    return mesh


@cache
def table(length: float = 1.2, width: float = 0.8, height: float = 0.72) -> Trimesh:
    """Return a top on four legs."""
    legs = [
        block(
            (0.05, 0.05, height - 0.03),
            (x * (length / 2 - 0.05), y * (width / 2 - 0.05), (height - 0.03) / 2),
        )
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    return joined([block((length, width, 0.04), (0, 0, height - 0.02)), *legs])


@cache
def mug() -> Trimesh:
    """Return a mug with a handle: 9 cm wide, 10 cm high."""
    body = creation.cylinder(
        0.045, 0.10, sections=48, transform=transformations.translation_matrix([0, 0, 0.05])
    )
    handle = creation.torus(0.028, 0.006, 32, 12)
    handle.apply_transform(transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation((0.05, 0, 0.05))
    inner = creation.cylinder(
        0.04, 0.10, sections=48, transform=transformations.translation_matrix([0, 0, 0.056])
    )
    return without(joined([body, handle]), inner)


@cache
def pencil() -> Trimesh:
    return creation.cylinder(
        0.004, 0.18, sections=8, transform=transformations.translation_matrix([0, 0, 0.09])
    )


@cache
def bowl() -> Trimesh:
    """Return a hemisphere of 16 cm, 1 cm thick, its lowest point on z = 0."""
    outer, inner = creation.icosphere(4, 0.16), creation.icosphere(4, 0.15)
    lid = block((0.4, 0.4, 0.2), (0, 0, 0.1))
    mesh = without(outer, inner, lid)
    mesh.apply_translation((0, 0, 0.16))
    return mesh


@cache
def pear() -> Trimesh:
    """Return a pear, 8 cm wide and 12 cm high."""
    height = np.linspace(0, 1, 24)
    radius = 0.04 * np.sqrt(np.clip(1 - (2.2 * height - 1) ** 2, 0, None)) * (height < 0.7)
    radius = np.maximum(radius, 0.018 * np.sqrt(np.clip(1 - ((height - 0.75) / 0.25) ** 2, 0, None)))
    radius[[0, -1]] = 0.0
    return creation.revolve(np.column_stack([radius, 0.12 * height]), sections=32)


@cache
def chair() -> Trimesh:
    """Return a chair: seat at 45 cm, back at its -X side, 90 cm high and 3 cm thick."""
    legs = [block((0.04, 0.04, 0.44), (x, y, 0.22)) for x in (-0.19, 0.19) for y in (-0.19, 0.19)]
    return joined(
        [block((0.44, 0.44, 0.03), (0, 0, 0.445)), block((0.03, 0.44, 0.5), (-0.205, 0, 0.65)), *legs]
    )


@cache
def coat() -> Trimesh:
    """Return a coat hung over a bar along Y, 3 cm thick, whose top is at the origin."""
    outer = block((0.062, 0.4, 0.45), (0, 0, 0.014 - 0.225))
    return without(outer, block((0.034, 0.5, 0.45), (0, 0, -0.225)), block((0.1, 0.5, 0.1), (0.06, 0, -0.45)))


@cache
def balloon() -> Trimesh:
    mesh = creation.icosphere(3, 0.15)
    return joined(
        [mesh, creation.cylinder(0.004, 0.3, transform=transformations.translation_matrix([0, 0, -0.28]))]
    )


@cache
def clock() -> Trimesh:
    """Return a disc across the X axis, 24 cm wide and 3 cm thick, its back at x = 0."""
    mesh = creation.cylinder(0.12, 0.03, sections=48)
    mesh.apply_transform(transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    mesh.apply_translation((-0.015, 0, 0))
    return mesh


@cache
def fruit() -> Trimesh:
    mesh = creation.icosphere(3, 0.04)
    mesh.apply_translation((0, 0, 0.04))
    return mesh
