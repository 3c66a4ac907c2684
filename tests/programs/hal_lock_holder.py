# SPDX-License-Identifier: GPL-2.0-or-later
"""hal_lock_holder.py KEY OFFSET: stops, like by Ctrl-Z, while it holds the lock in the shared memory with this key.

The program itself ends; a process of its own stays behind.
"""

import ctypes
import os
import signal
import sys

libc = ctypes.CDLL(None)
libc.shmat.restype = ctypes.c_void_p
memory = libc.shmat(libc.shmget(int(sys.argv[1], 16), 0, 0), None, 0)
child = os.fork()
if child == 0:
    ctypes.c_ulong.from_address(memory + int(sys.argv[2])).value |= 1
    os.kill(os.getpid(), signal.SIGSTOP)
os.waitpid(child, os.WUNTRACED)
