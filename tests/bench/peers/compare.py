# SPDX-License-Identifier: Apache-2.0
"""VTK's ways to show a surface, in turn with Fanlight's bench.

The command. `run` starts it with an X server. --help prints the first sentence above.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from bench_case import BenchCase
from failure import Failure
from fanlight import ROWS, Fanlight
from peer import PIPELINES
from report import print_report, report_of
from scene import Scene
from shading import LEVEL

FANLIGHT = Path(__file__).resolve().parents[3] / "build/release/server/fanlight"
SMALL = {"spacing": "2", "rounds": 1, "size": 256, "rows": "r1/paper"}


def arguments():
    parser = argparse.ArgumentParser(prog="peers/run", description=__doc__.partition(".")[0])
    add = parser.add_argument
    add("--fanlight", type=Path, default=FANLIGHT, help="the program to compare")
    add("--recorder", type=Path, help="phantom_recording; by default that of the same build")
    add("--spacing", default="0.33,0.66", help="of the grids for VTK, mm (%(default)s)")
    add("--rounds", type=int, default=5, help="how often each takes its turn (%(default)s)")
    add("--peers", default=",".join(PIPELINES), help="which of VTK's (%(default)s)")
    add("--rows", default=",".join(row.name for row in ROWS), help="of fanlight bench (%(default)s)")
    add("--level", type=float, default=LEVEL, help="grey level of VTK's surface (%(default)s)")
    add("--size", type=int, help="of VTK's pictures, pixels, where it shall not be that of the row")
    add("--small", action="store_true", help="one round on a coarse grid, to know that all works")
    add("--json", type=Path, help="writes everything, each single time too, to this file")
    add("--pictures", type=Path, help="keeps everybody's picture of the first volume in this folder")
    given = parser.parse_args()
    if given.small:
        vars(given).update(SMALL)
    if given.rounds < 1:
        parser.error("--rounds expects 1 or more")
    return given


def listed(text, known, kind):
    """The names in a comma-separated text. Raises Failure if one is not in `known`; `kind` is for its message."""
    names = text.split(",")
    for name in names:
        if name not in known:
            raise Failure(f'there is no {kind} "{name}", expected some of {", ".join(known)}')
    return names


def spacings_mm(text):
    """The numbers in a comma-separated text. Raises Failure unless each is 0.1 to 20."""
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        numbers = []
    if not numbers or not all(0.1 <= number <= 20 for number in numbers):
        raise Failure(f'the spacing is "{text}", expected 0.1 to 20 mm, several with commas between')
    return numbers


def cases_of(given):
    """A case for each spacing with each row whose step is at most 10 % larger than the spacing."""
    rows = {row.name: row for row in ROWS}
    chosen = [rows[name] for name in listed(given.rows, rows, "row of fanlight bench")]
    cases = [
        BenchCase(row, spacing_mm, given.size or row.size)
        for spacing_mm in spacings_mm(given.spacing)
        for row in chosen
        if row.equals(spacing_mm) or row.step_mm < spacing_mm
    ]
    if not cases:
        raise Failure("every row is coarser than every spacing, expected a spacing of 0.29 mm or more")
    return cases


def compare(given):
    program = given.fanlight.resolve()
    fanlight = Fanlight(program)
    fanlight.check()
    peer_names = listed(given.peers, PIPELINES, "peer")
    cases = cases_of(given)
    default_recorder = program.parent.parent / "tests/bench/phantom_recording"
    recorder = (given.recorder or default_recorder).resolve()
    if given.pictures:
        given.pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        scene = Scene(fanlight, recorder, Path(folder), given.level, given.pictures)
        for case in cases:
            case.run(fanlight, scene, peer_names, given.rounds)
    report = report_of(cases, given.rounds, given.level, fanlight.version())
    print_report(report)
    if given.json:
        given.json.write_text(json.dumps(report, indent=1) + "\n", encoding="ascii")


def main():
    try:
        compare(arguments())
    except Failure as failure:
        sys.exit(f"peers: {failure}")


if __name__ == "__main__":
    main()
