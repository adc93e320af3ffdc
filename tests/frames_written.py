"""Frames written to files, for tests and samples: a JSON file, and images or a cloud beside it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from deixis.frames import Array
from deixis.perception import Frame


def described(frame: Frame) -> dict[str, Any]:
    """Return what the frame file says, without the names of images."""
    camera = frame.camera
    return {
        "deixis_frame": 1,
        "stamp": frame.stamp,
        "robot": {"position": frame.position.tolist(), "heading": frame.heading, "label": frame.robot},
        "intrinsics": {
            "width": camera.width, "height": camera.height,
            "fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy,
        },
        "pose": {"matrix": camera.camera2world.tolist()},
        **({} if frame.noise is None else {"noise": frame.noise}),
        "things": [
            {"instance": number, "labels": [{"name": str(one.name), "score": one.score} for one in labels]}
            for number, labels in frame.labels.items()
        ],
    }  # fmt: skip


def write_frame(frame: Frame, path: Path, *, images: str = ".png") -> Path:
    """Write a frame with its images as .png or .npy; return its path."""
    data = described(frame)
    for noun, image in (("depth", frame.depth), ("instances", frame.instances)):
        beside = path.with_name(f"{path.stem}.{noun}{images}")
        data[noun] = beside.name
        if images == ".npy":
            np.save(beside, image.astype(np.float32 if noun == "depth" else np.int32))
        else:
            steps = np.rint(image * 1000.0) if noun == "depth" else image
            Image.fromarray(steps.astype(np.uint16)).save(beside, optimize=True)
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    return path


def write_cloud(frame: Frame, path: Path, kind: str) -> Path:
    """Write a frame as a cloud in a .ply, .pcd or .npz; return its path."""
    v, u = np.nonzero(frame.depth > 0.0)
    points = frame.camera.points(u, v, frame.depth[v, u])
    beside = save_points(path.with_name(f"{path.stem}{kind}"), points, frame.instances[v, u])
    data = described(frame)
    del data["intrinsics"], data["pose"]
    path.write_text(json.dumps({**data, "cloud": beside.name}), encoding="utf-8")
    return path


def save_points(path: Path, points: Array, instances: Any) -> Path:
    """Write labelled points in the format of the file's ending."""
    if path.suffix == ".npz":
        np.savez(path, points=points.astype(np.float32), instances=np.asarray(instances, dtype=np.int32))
        return path
    rows = np.empty(len(points), [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("instance", "<u4")])
    for axis, name in enumerate("xyz"):
        rows[name] = points[:, axis]
    rows["instance"] = instances
    if path.suffix == ".ply":
        fields = "".join(f"property float {name}\n" for name in "xyz") + "property uint instance\n"
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{fields}end_header\n"
    else:
        head = (
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z instance\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
            f"WIDTH {len(rows)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(rows)}\nDATA binary\n"
        )
    path.write_bytes(head.encode("ascii") + rows.tobytes())
    return path
