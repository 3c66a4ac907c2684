# SPDX-License-Identifier: GPL-2.0-or-later
"""No function of a module may take more than 4096 bytes of a realtime thread's stack: it does not compile."""

import json
import os
import shlex
import subprocess
import unittest

from plumb_folder import TemporaryFolder

BUILD = os.path.abspath(os.environ["PLUMB_BUILD"])

FUNCTION = "void use(char*);\nvoid deep();\nvoid deep() {\n    char frame[%d];\n    use(frame);\n}\n"


class StackUsage(unittest.TestCase):
    def compile(self, size):
        """Compiles a function with such a frame as a module is compiled."""
        with open(os.path.join(BUILD, "compile_commands.json")) as file:
            entries = json.load(file)
        entry = next(entry for entry in entries if entry["file"].endswith("/components/plants/sim_drive_load.cpp"))
        words = shlex.split(entry["command"])
        with TemporaryFolder() as folder:
            source = os.path.join(folder, "deep.cpp")
            with open(source, "w") as file:
                file.write(FUNCTION % size)
            words[words.index("-o") + 1] = os.path.join(folder, "deep.o")
            words[words.index(entry["file"])] = source
            return subprocess.run(words, cwd=entry["directory"], capture_output=True, text=True)

    def test_a_frame_that_is_too_large_does_not_compile(self):
        compiled = self.compile(4096)
        self.assertNotEqual(compiled.returncode, 0)
        self.assertRegex(compiled.stderr, "error: stack usage is [0-9]+ bytes")

    def test_a_large_one_does(self):
        compiled = self.compile(4000)
        self.assertEqual(compiled.returncode, 0, compiled.stderr)


if __name__ == "__main__":
    unittest.main()
