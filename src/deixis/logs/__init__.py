"""Logs: recordings of robots in, as scenes that change; scenes and what holds in them out, for Foxglove."""

from __future__ import annotations

from deixis.logs.reading import Choices, Log, read_bag
from deixis.logs.report import Report

__all__ = ["Choices", "Log", "Report", "read_bag"]
