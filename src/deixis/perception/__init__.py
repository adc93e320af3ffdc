"""Perception: depth images and clouds with labelled regions become a scene (section 4.1 of the paper)."""

from __future__ import annotations

from deixis.perception.camera import Camera
from deixis.perception.frame import CloudFrame, Frame
from deixis.perception.frame_file import load_frame
from deixis.perception.mapping import Map, perceive

__all__ = ["Camera", "CloudFrame", "Frame", "Map", "load_frame", "perceive"]
