# SPDX-License-Identifier: GPL-2.0-or-later
"""What scripts/package and CMake refuse to build."""

import os
import subprocess
import unittest

from tree import ROOT, own_folder


def output_of(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


class Refused(unittest.TestCase):
    def package(self, *words):
        return output_of(os.path.join(ROOT, "scripts", "package"), *words)

    def test_a_processor_that_plumb_is_not_for(self):
        message = "scripts/package: Plumb is for amd64 and arm64; armhf is not supported\n"
        self.assertEqual(self.package("--arch", "armhf", "trixie"), (1, message))

    def test_another_debian(self):
        self.assertEqual(self.package("bullseye"), (1, "scripts/package: name a Debian: bookworm (12) or trixie (13)\n"))

    def test_cmake_of_a_processor_of_32_bits(self):
        build = own_folder(self)
        # The compiler of this computer, which CMake is told to know already.
        known = {"CMAKE_CXX_COMPILER_FORCED": "ON", "CMAKE_SIZEOF_VOID_P": "4"}
        status, output = output_of("cmake", "-G", "Ninja", "-S", ROOT, "-B", build, *(f"-D{name}={value}" for name, value in known.items()))
        self.assertEqual(status, 1, output)
        self.assertIn("Plumb is for amd64 and arm64.", output)


if __name__ == "__main__":
    unittest.main()
