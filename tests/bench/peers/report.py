"""What is printed and written of a comparison."""

import os
import platform
from datetime import datetime, timezone

from vtkmodules.vtkCommonCore import vtkSMPTools, vtkVersion

# Of the peers, and for a person.
STAGES = {"new_volume": "new volume", "camera": "camera move"}
# Which of theirs is held against which of ours.
RATIOS = {"new_volume": "new_volume", "whole_volume": "new_volume", "camera": "camera"}


def report_of(bouts, rounds, level, fanlight_version):
    """Everything, ready for JSON."""
    return {
        "date": datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "machine": f"{len(os.sched_getaffinity(0))} cores of {_processor()}",
        "versions": {
            "fanlight": f"{fanlight_version} on {bouts[0].device}",
            "vtk": f"{vtkVersion.GetVTKVersion()} ({vtkSMPTools.GetBackend()})",
            "opengl": bouts[0].opengl,
        },
        "rounds": rounds,
        "level": level,
        "bouts": [_bout(bout) for bout in bouts],
    }


def _bout(bout):
    peers = [_peer(bout, name) for name in bout.peers]
    return {
        "row": bout.row.name,
        "spacing_mm": bout.spacing_mm,
        "dimensions": [int(voxels) for voxels in bout.dimensions],
        "picture": bout.size,
        "equal_resolution": bout.equal_resolution,
        "ours": {**_times(bout.ours), "overlap": bout.our_overlap},
        "peers": peers,
        "fastest": {stage: min(peers, key=lambda peer: peer["median_ms"][stage])["name"] for stage in STAGES},
    }


def _peer(bout, name):
    times = bout.peers[name]
    ratios = {ours: times.median_ms(theirs) / bout.ours.median_ms(ours) for ours, theirs in RATIOS.items()}
    return {"name": name, **_times(times), "ratios": ratios, "overlap": bout.overlaps[name]}


def _times(times):
    return {"median_ms": {stage: times.median_ms(stage) for stage in times.ms}, "all_ms": times.ms}


def _processor():
    with open("/proc/cpuinfo", encoding="ascii") as file:
        models = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    return models[0] if models else platform.machine()


def print_report(report):
    """The table of each bout, and who of VTK was fastest."""
    versions = report["versions"]
    print(f"{report['date']}, {report['machine']}")
    print(f"medians of {report['rounds']} rounds, VTK's surface at grey level {report['level']:g}")
    print(f"{versions['fanlight']}; VTK {versions['vtk']}; OpenGL {versions['opengl']}")
    for bout in report["bouts"]:
        _print_bout(bout)


def _print_bout(bout):
    voxels = " x ".join(str(number) for number in bout["dimensions"])
    equal = ", equal resolution" if bout["equal_resolution"] else ""
    print(f"\n{bout['spacing_mm']} mm ({voxels}), {bout['picture']} pixels square, {bout['row']}{equal}")
    print(f"{'':14}{'new volume ms':>14}{'ratio':>8}{'camera ms':>12}{'ratio':>8}{'overlap':>9}")
    ours, overlap = bout["ours"]["median_ms"], bout["ours"]["overlap"]
    print(f"{'fanlight':14}{ours['new_volume']:14.1f}{'':8}{ours['camera']:12.1f}{'':8}{overlap:9.2f}")
    print(f"{'  all at once':14}{ours['whole_volume']:14.1f}")
    for peer in bout["peers"]:
        took_ms, ratios = peer["median_ms"], peer["ratios"]
        print(
            f"{peer['name']:14}{took_ms['new_volume']:14.1f}{ratios['new_volume']:8.1f}"
            f"{took_ms['camera']:12.1f}{ratios['camera']:8.1f}{peer['overlap']:9.2f}"
        )
    for stage, title in STAGES.items():
        _print_fastest(bout, stage, title)


def _print_fastest(bout, stage, title):
    peer = next(each for each in bout["peers"] if each["name"] == bout["fastest"][stage])
    times = f"{peer['ratios'][stage]:.1f} times ours"
    if stage == "new_volume":
        times += f" ({peer['ratios']['whole_volume']:.1f} times where all frames come at once)"
    print(f"VTK's fastest, {title}: {peer['name']}, {peer['median_ms'][stage]:.0f} ms, {times}")
