"""Perception: depth images and point clouds with labelled regions become a scene (section 4.1 of the paper)."""

from __future__ import annotations

from deixis.perception.camera import Camera
from deixis.perception.frame import Frame
from deixis.perception.mapping import Map, perceive

__all__ = ["Camera", "Frame", "Map", "perceive"]
