"""A synthetic depth camera: known meshes seen from known poses, with noise and flying pixels on request.

Each pixel's ray meets each triangle in closed form, so that depths are exact to rounding before noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

from deixis.frames import Array
from deixis.perception import Camera

NEAR = 0.05


@dataclass(frozen=True)
class Body:
    """A thing of the true scene: its number in the image, and its triangles in the world frame."""

    number: int
    vertices: Array
    faces: np.ndarray


@dataclass(frozen=True)
class Picture:
    """What a camera sees: depth along its Z axis (0 where nothing is), and whose pixel it is."""

    depth: Array
    instances: np.ndarray
    seen: Mapping[int, int]
    """Pixels of each body."""
    alone: Mapping[int, int]
    """Pixels it would have were it alone in the room."""


def looking(eye: Sequence[float], target: Sequence[float]) -> Array:
    """Return the pose (4, 4) of a camera (X right, Y down, Z forward) in the world frame."""
    forward = np.subtract(target, eye).astype(float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    pose[:3, 3] = eye
    return pose


def render(camera: Camera, bodies: Sequence[Body]) -> Picture:
    """Return what the camera sees of some bodies, without noise."""
    shape = (camera.height, camera.width)
    depth = np.full(shape, np.inf)
    instances = np.zeros(shape, dtype=np.int64)
    alone = {}
    rotation, eye = camera.camera2world[:3, :3], camera.camera2world[:3, 3]
    for body in bodies:
        corners = ((body.vertices - eye) @ rotation)[body.faces]
        mine = np.full(shape, np.inf)
        for triangle in corners:
            _draw(camera, triangle, mine)
        hit = np.isfinite(mine)
        alone[body.number] = int(hit.sum())
        nearer = mine < depth
        depth[nearer] = mine[nearer]
        instances[nearer] = body.number
    seen = {body.number: int((instances == body.number).sum()) for body in bodies}
    return Picture(np.where(np.isfinite(depth), depth, 0.0), instances, seen, alone)


def _draw(camera: Camera, triangle: Array, depth: Array) -> None:
    """Put a triangle, in the camera's frame, into a depth image."""
    a, b, c = triangle
    normal = np.cross(b - a, c - a)
    offset = float(normal @ a)
    if (triangle[:, 2] < NEAR).all() or offset == 0.0:
        return
    left, right, top, bottom = 0, camera.width, 0, camera.height
    if (triangle[:, 2] > NEAR).all():
        u = camera.fx * triangle[:, 0] / triangle[:, 2] + camera.cx
        v = camera.fy * triangle[:, 1] / triangle[:, 2] + camera.cy
        left, right = max(left, int(np.ceil(u.min()))), min(right, int(np.floor(u.max())) + 1)
        top, bottom = max(top, int(np.ceil(v.min()))), min(bottom, int(np.floor(v.max())) + 1)
        if left >= right or top >= bottom:
            return
    x = (np.arange(left, right) - camera.cx) / camera.fx
    y = ((np.arange(top, bottom) - camera.cy) / camera.fy)[:, None]
    inside = np.ones((bottom - top, right - left), dtype=bool)
    for edge in (np.cross(b, c), np.cross(c, a), np.cross(a, b)):
        inside &= (edge[0] * x + edge[1] * y + edge[2]) * np.sign(offset) >= 0.0
    along = normal[0] * x + normal[1] * y + normal[2]
    with np.errstate(divide="ignore"):
        t = offset / along
    part = depth[top:bottom, left:right]
    better = inside & (t > NEAR) & (t < part)
    part[better] = t[better]


def noisy(
    picture: Picture, sigma: float, rng: np.random.Generator, flying: float = 0.0, dropped: float = 0.0
) -> Array:
    """Return the depth image with Gaussian noise (metres), flying pixels at edges and pixels without depth.

    Parameters
    ----------
    picture : Picture
    sigma : float
        Metres.
    rng : numpy.random.Generator
    flying : float
        Share of the pixels at depth edges that lie between the two depths.
    dropped : float
        Share of pixels without depth.
    """
    depth = picture.depth.copy()
    if flying:
        for axis in (0, 1):
            other = np.roll(picture.depth, 1, axis=axis)
            edge = (np.abs(other - picture.depth) > 0.1) & (other > 0.0) & (depth > 0.0)
            edge &= rng.random(depth.shape) < flying
            share = rng.random(depth.shape)
            depth = np.where(edge, share * other + (1.0 - share) * depth, depth)
    valid = depth > 0.0
    depth = np.where(valid, depth + rng.normal(0.0, sigma, depth.shape), 0.0) if sigma else depth
    if dropped:
        depth[rng.random(depth.shape) < dropped] = 0.0
    return np.maximum(depth, 0.0)


def placed(mesh: trimesh.Trimesh, at: Sequence[float], yaw: float = 0.0) -> tuple[Array, np.ndarray]:
    """Return a mesh turned about the vertical and set down: its lowest point is at the given height."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    vertices = np.asarray(mesh.vertices) @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    vertices = vertices - [0.0, 0.0, vertices[:, 2].min()]
    return vertices + np.asarray(at, dtype=float), np.asarray(mesh.faces)
