# SPDX-License-Identifier: Apache-2.0
"""Sessions as HDF5 files, in the layout of the recordings of volumetric_drilling, version 3.

The layout is that of `scripts/New Data Structure Format.md` at commit 195b387 of
https://github.com/LCSR-SICKKIDS/volumetric_drilling, with the rows of `voxel_removed` and `voxel_color` as
`scripts/data_record_v3.py` writes them. docs/guide/python.md lists the datasets.
"""
from typing import Any, Dict, List, Optional

import numpy as np

from osteon._files import complete
from osteon.errors import DifferError, UnavailableError
from osteon.session import Session, has_force
from osteon.units import pm, to_mm
from osteon.world import World

_CAMERA_NS = 20_000_000  # the period of vision_data; volumetric_drilling records it at about 50 Hz

_README = """\
Written by osteon from a session, in the layout of the recordings of volumetric_drilling, version 3.
Positions are in metres. Quaternions are qx, qy, qz, qw. A pose maps the frame of the object to that of the bone, which
is the LPS frame of the CT: x to the patient's left, y to the back, z to the head. The bone does not move.
Times are seconds of the clock of the session. A wrench is the force in N and the torque in N m about the origin of the
tool, on the device, in the frame of the bone. There are no cameras, pictures, depths and segmentations.
"""
_VOXELS_README = """\
A group is the voxels that one tick removed: voxel_time_stamp is its time, voxel_count the number of its voxels.
A row of voxel_removed is the number of a group and the index x, y, z of a voxel. The rows of voxel_color are in the
same order: the number of the group, and the density as red, green and blue (8 HU each, 0 to 255), and alpha.
Both have no rows if the session was exported without a world.
"""


def poses_of(ticks: np.ndarray) -> np.ndarray:
    """Returns x, y, z in metres and qx, qy, qz, qw, one row for each tick."""
    q = ticks["tick"]["q30"] / float(1 << 30)
    return np.hstack([ticks["tick"]["t_pm"] / 1e12, q[:, 1:], q[:, :1]])


def voxels_of(session: Session, world: World) -> Dict[str, np.ndarray]:
    """Replays a session and returns the voxels that each tick removes, as datasets.

    Raises
    ------
    DifferError
        If a tick has another result than the recorded one.
    """
    bone, path = world.bone, session.path
    before = bone.voxels()
    layer, size = bone.chunk_dims[0] * bone.chunk_dims[1], bone.chunk_size
    times: List[float] = []
    rows, colors = [np.empty((0, 4))], [np.empty((0, 5))]
    for number, step in enumerate(world.steps(path)):
        if world.step_digest != session.ticks["digest"][number]:
            raise DifferError(f"tick {number} has another result than the recorded one: the bone or a tool differs")
        report = world.report
        if not step.removed or report is None:
            continue
        first = int(report.chunks["chunk"][0]) // layer * size
        end = min((int(report.chunks["chunk"][-1]) // layer + 1) * size, before.shape[0])
        now = bone.voxels(first, end - first)
        at = np.nonzero(before[first:end] != now)
        number_of_group = np.full((len(at[0]), 1), float(len(times)))
        grey = np.clip(before[first:end][at] // 8, 0, 255).astype(float)
        rows.append(np.column_stack([number_of_group, at[2], at[1], at[0] + first]))
        colors.append(np.column_stack([number_of_group, grey, grey, grey, np.full_like(grey, 255.0)]))
        times.append(path.ticks["t_ns"][number] / 1e9)
        before[first:end] = now
    # The first element of `rows` has no rows, and each other element is a group.
    return {"voxel_time_stamp": np.array(times, float), "voxel_removed": np.vstack(rows),
            "voxel_color": np.vstack(colors), "voxel_count": np.array([len(group) for group in rows[1:]], np.uint64)}


def datasets_of(session: Session, world: Optional[World]) -> Dict[str, Any]:
    """Returns the datasets of a file by their names."""
    ticks = session.ticks
    time, tool = ticks["tick"]["t_ns"] / 1e9, ticks["tick"]["tool"]
    poses, still = poses_of(ticks), np.array([0, 0, 0, 0, 0, 0, 1.0])
    force, removal = has_force(ticks), ticks["removed"] > 0
    change = np.flatnonzero(np.append([True], tool[1:] != tool[:-1])[:len(ticks)])
    frame: List[int] = []
    due = 0
    for number, t_ns in enumerate(ticks["tick"]["t_ns"].tolist()):
        if not frame or t_ns >= due:
            frame.append(number)
            due = t_ns + _CAMERA_NS
    voxels = {"voxel_time_stamp": time[removal], "voxel_count": ticks["removed"][removal].astype(np.uint64),
              "voxel_removed": np.empty((0, 4)), "voxel_color": np.empty((0, 5))}
    if world is not None:
        voxels = voxels_of(session, world)
    spacing = session.header.get("bone_spacing_mm", "").split(",")
    volume = float(np.prod([to_mm(pm(mm)) for mm in spacing])) if len(spacing) == 3 else float("nan")
    events, series = "physics_data/intermittent_data/", "physics_data/continuous_data/high_frequency_poses/"
    vision = "vision_data/continuous_data/"
    return {
        "metadata_v3/README": _README,
        "metadata_v3/voxel_volume": volume,
        "metadata_v3/osteon_session": "".join(f"{key}: {value}\n" for key, value in session.header.items()),
        vision + "time": time[frame],
        vision + "pose_mastoidectomy_drill": poses[frame],
        vision + "pose_mastoidectomy_volume": np.tile(still, (len(frame), 1)),
        series + "drill_pose/time_stamp": time,
        series + "drill_pose/pose": poses,
        series + "anatomy_pose/time_stamp": time[:1],
        series + "anatomy_pose/pose": np.tile(still, (len(time[:1]), 1)),
        events + "drill_force_feedback/time_stamp": time[force],
        events + "drill_force_feedback/wrench": np.hstack([ticks["force_un"][force], ticks["torque_unm"][force]]) / 1e6,
        events + "burr_change/time_stamp": time[change],
        events + "burr_change/tool": tool[change],
        **{events + "voxels_removed/" + name: values for name, values in voxels.items()},
        events + "voxels_removed/README": _VOXELS_README,
    }


def write(session: Session, path: Any, world: Optional[World]) -> None:
    """Implements Session.write_hdf5."""
    try:
        import h5py  # pylint: disable=import-outside-toplevel
    except ImportError:
        raise UnavailableError("h5py is not installed: pip install osteon[hdf5]") from None
    datasets = datasets_of(session, world)
    with complete(path) as temporary, h5py.File(temporary, "w") as file:
        file.create_group("vision_data/intermittent_data")
        for name, values in datasets.items():
            rows = isinstance(values, np.ndarray) and len(values) > 0
            file.create_dataset(name, data=values, compression="gzip" if rows else None)
        file["metadata_v3/voxel_volume"].attrs["units"] = "mm^3, millimeters cubed"
