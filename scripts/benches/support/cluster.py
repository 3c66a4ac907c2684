# SPDX-License-Identifier: GPL-2.0-or-later
"""Simulations on the workers of a Dask scheduler, each with the same build of Plumb as this computer."""

import concurrent.futures
import contextlib
import functools
import glob
import hashlib
import logging
import os
import pickle
import platform
import subprocess

import numpy as np

from support.simulations import BENCHES, BUILD, ROOT


def digest(folder, *patterns):
    """The digest of the names and bytes of files."""
    found = hashlib.sha256()
    paths = {path for pattern in patterns for path in glob.glob(os.path.join(folder, pattern), recursive=True)}
    for path in sorted(paths):
        with open(path, "rb") as file:
            found.update(os.path.relpath(path, folder).encode() + b"\0" + file.read() + b"\0")
    return found.hexdigest()[:12]


BENCHES_LOADED = digest(BENCHES, "**/*.py")  # the code of this process, even if the files change later


PARTS = ("bin/plumb-host", "modules/*.so", "lib/linuxcnc/modules/*.so", "python/*.py")  # built, or installed


def identity():
    """All that makes the figures of a simulation: name -> text."""
    return {
        "Plumb": f"{plumb_version()}, build {digest(BUILD, *PARTS)}",
        "benches": BENCHES_LOADED,
        "configurations": digest(os.path.join(ROOT, "configs"), *(f"*/*.{end}" for end in ("hal", "ngc", "csv"))),
        "LinuxCNC": version_of("linuxcnc-uspace"),
        "libc": version_of("libc6"),
        "Python": platform.python_version(),
        "numpy": np.__version__,
        "processor": platform.machine() + cpu_level(),
    }


def plumb_version():
    words = [os.path.join(BUILD, "bin", "plumb"), "--version"]
    return subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True).stdout.split()[1]


def version_of(package):
    words = ["dpkg-query", "-W", "-f=${Version} ", package]
    return subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False).stdout.strip()


def cpu_level():
    """The level of x86-64, by which the C library chooses its code: "-v3" has AVX2 and FMA."""
    flags = set()
    with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
        for line in file:
            if line.startswith("flags"):
                flags = set(line.split())
                break
    if {"avx512f", "avx512bw", "avx512vl"} <= flags:
        return "-v4"
    return "-v3" if {"avx2", "fma"} <= flags else ""


def differences(here, there):
    return "; ".join(f"{name} {there.get(name)} there, {here[name]} here" for name in here if there.get(name) != here[name])


def simulate_there(expected, simulate, task):
    """On a worker. Those that came after the first look at all of them are looked at here."""
    found = differences(expected, identity())
    if found:
        raise RuntimeError(f"the worker on {platform.node()} is refused: {found}")
    return simulate(*task, lambda seconds: True)


def unpacked_by_worker(function, *arguments):
    """A function and its argument for a worker. The scheduler, which lacks the benches, sees bytes only."""
    return lambda packed: pickle.loads(packed)(), pickle.dumps(functools.partial(function, *arguments))


class Cluster:
    """The workers of the Dask scheduler at an address. One that is lost has its simulations done by another."""

    def __init__(self, address):
        self._address = address

    def simulate_all(self, simulate, tasks, progress):
        try:
            import distributed
        except ImportError:
            raise RuntimeError("--cluster needs Dask: apt install python3-distributed") from None
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # an error here is one sentence
        try:
            client = distributed.Client(self._address, timeout=10)
        except (OSError, ValueError) as error:
            raise RuntimeError(f"no Dask scheduler at {self._address}: {error}") from None
        with client:
            here = identity()
            self._refuse_others(client, here)
            executor = client.get_executor(pure=False)
            futures = [executor.submit(*unpacked_by_worker(simulate_there, here, simulate, task)) for task in tasks]
            try:
                while concurrent.futures.wait(futures, 0.2, concurrent.futures.FIRST_EXCEPTION).not_done:
                    if any(future.done() and future.exception() for future in futures):
                        break
                    progress.show_part(sum(future.done() for future in futures) / len(futures))
                progress.end()
                return [future.result() for future in futures if future.done()]
            except (distributed.KilledWorker, concurrent.futures.CancelledError) as error:
                raise RuntimeError(f"the scheduler at {self._address} or too many of its workers were lost: {error}") from None
            finally:
                with contextlib.suppress(OSError):  # the scheduler is gone
                    executor.shutdown(wait=False)  # cancels waiting tasks

    def _refuse_others(self, client, here):
        """Raises RuntimeError that names each worker of another build, or reports that there is none at all."""
        if not client.scheduler_info()["workers"]:
            raise RuntimeError(f"the Dask scheduler at {self._address} has no worker")
        refused = []
        for worker, there in client.run(identity, on_error="return").items():
            if isinstance(there, Exception):
                found = f"it does not find the benches of Plumb ({there}); see scripts/benches/README.md"
            else:
                found = differences(here, there)
            if found:
                refused.append(f"the worker {worker} is refused: {found}")
        if refused:
            raise RuntimeError("\n".join(refused))
