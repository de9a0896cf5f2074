# SPDX-License-Identifier: Apache-2.0
"""The report of a comparison: a table on standard output, and a dictionary for JSON."""

import os
import platform
from datetime import datetime, timezone

from vtkmodules.vtkCommonCore import vtkSMPTools, vtkVersion

# Titles of the stages of a peer.
STAGES = {"new_volume": "new volume", "camera": "camera move"}
# The peers' stage that each stage of Fanlight is compared with.
RATIOS = {"new_volume": "new_volume", "whole_volume": "new_volume", "camera": "camera"}


def report_of(cases, rounds, level, fanlight_version):
    """All parameters and results of the finished cases, in types that JSON can represent."""
    return {
        "date": datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "machine": f"{len(os.sched_getaffinity(0))} cores of {_processor()}",
        "versions": {
            "fanlight": f"{fanlight_version} on {cases[0].device}",
            "vtk": f"{vtkVersion.GetVTKVersion()} ({vtkSMPTools.GetBackend()})",
            "opengl": cases[0].opengl,
        },
        "rounds": rounds,
        "level": level,
        "bouts": [_case_report(case) for case in cases],
    }


def _case_report(case):
    peers = [_peer_report(case, name) for name in case.peer_times]
    return {
        "row": case.row.name,
        "spacing_mm": case.spacing_mm,
        "dimensions": [int(voxels) for voxels in case.dimensions],
        "picture": case.size,
        "equal_resolution": case.equal_resolution,
        "ours": {**_times(case.fanlight_times), "overlap": case.fanlight_overlap},
        "peers": peers,
        "fastest": {stage: min(peers, key=lambda peer: peer["median_ms"][stage])["name"] for stage in STAGES},
    }


def _peer_report(case, name):
    times = case.peer_times[name]
    ratios = {
        stage: times.median_ms(peer_stage) / case.fanlight_times.median_ms(stage)
        for stage, peer_stage in RATIOS.items()
    }
    return {"name": name, **_times(times), "ratios": ratios, "overlap": case.peer_overlaps[name]}


def _times(times):
    return {"median_ms": {stage: times.median_ms(stage) for stage in times.ms}, "all_ms": times.ms}


def _processor():
    with open("/proc/cpuinfo", encoding="ascii") as file:
        models = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    return models[0] if models else platform.machine()


def print_report(report):
    """Prints the table of each case, and the fastest peer for each stage."""
    versions = report["versions"]
    print(f"{report['date']}, {report['machine']}")
    print(f"medians of {report['rounds']} rounds, VTK's surface at grey level {report['level']:g}")
    print(f"{versions['fanlight']}; VTK {versions['vtk']}; OpenGL {versions['opengl']}")
    for case in report["bouts"]:
        _print_case(case)


def _print_case(case):
    voxels = " x ".join(str(number) for number in case["dimensions"])
    equal = ", equal resolution" if case["equal_resolution"] else ""
    print(f"\n{case['spacing_mm']} mm ({voxels}), {case['picture']} pixels square, {case['row']}{equal}")
    print(f"{'':14}{'new volume ms':>14}{'ratio':>8}{'camera ms':>12}{'ratio':>8}{'overlap':>9}")
    fanlight_ms, overlap = case["ours"]["median_ms"], case["ours"]["overlap"]
    print(f"{'fanlight':14}{fanlight_ms['new_volume']:14.1f}{'':8}{fanlight_ms['camera']:12.1f}{'':8}{overlap:9.2f}")
    print(f"{'  all at once':14}{fanlight_ms['whole_volume']:14.1f}")
    for peer in case["peers"]:
        median_ms, ratios = peer["median_ms"], peer["ratios"]
        print(
            f"{peer['name']:14}{median_ms['new_volume']:14.1f}{ratios['new_volume']:8.1f}"
            f"{median_ms['camera']:12.1f}{ratios['camera']:8.1f}{peer['overlap']:9.2f}"
        )
    for stage, title in STAGES.items():
        _print_fastest(case, stage, title)


def _print_fastest(case, stage, title):
    peer = next(each for each in case["peers"] if each["name"] == case["fastest"][stage])
    times = f"{peer['ratios'][stage]:.1f} times ours"
    if stage == "new_volume":
        times += f" ({peer['ratios']['whole_volume']:.1f} times where all frames come at once)"
    print(f"VTK's fastest, {title}: {peer['name']}, {peer['median_ms'][stage]:.0f} ms, {times}")
