# SPDX-License-Identifier: Apache-2.0
"""A server for a test, on a port of its own or a given one."""

import contextlib
import os
import re
import subprocess
import tempfile
import time

SOURCE = "phantom:scene=relief,probe=r1,frames=18,rate=60,speckle=off"


@contextlib.contextmanager
def served(*options, source=SOURCE, listen="127.0.0.1:0"):
    """Yields (URL, process). Its folders are its own."""
    with tempfile.TemporaryDirectory(prefix="fanlight-test-") as folder:
        command = [os.environ["FANLIGHT"], "serve", source, "--listen", listen]
        command += ["--presets", folder, "--recordings", folder, *options]
        with open(os.path.join(folder, "log"), "w+") as log:
            process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
            try:
                yield _address(log.name, process), process
            finally:
                process.terminate()
                process.wait(30)


def _address(log, process):
    for _ in range(600):
        with open(log) as file:
            text = file.read()
        found = re.search(r"http://127\.0\.0\.1:\d+", text)
        if found:
            return found.group()
        if process.poll() is not None:
            break
        time.sleep(0.1)
    raise AssertionError(f"the server did not start: {text}")
