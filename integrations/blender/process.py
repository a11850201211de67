# SPDX-License-Identifier: MIT
"""A run of `mlt` beside Blender."""

import re
import subprocess
import threading

PROGRESS = "progress: "


class Process:
    """A program that runs, and what it says."""

    def __init__(self, command):
        self._child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, encoding="utf-8")
        self._reader = threading.Thread(target=self._read, daemon=True)
        self.messages = []
        self.progress = ""
        self._is_stopped = False
        self._reader.start()

    def _read(self):
        for line in self._child.stderr:
            if line.startswith(PROGRESS):
                self.progress = line.removeprefix(PROGRESS).strip()
            else:
                self.messages.append(line.strip())

    @property
    def share(self):
        """The share of the render that is done."""
        percent = re.match(r"(\d+) %", self.progress)
        return int(percent[1]) / 100.0 if percent else 0.0

    def is_done(self):
        return self._child.poll() is not None

    def stop(self):
        """Ends the render early. Where there are signals, mlt writes the image as far as it has come; a second one would end it at once."""
        if not self._is_stopped:
            self._is_stopped = True
            self._child.terminate()

    def wait(self):
        """Waits for the end; returns the exit code."""
        code = self._child.wait()
        self._reader.join()
        return code
