# SPDX-License-Identifier: GPL-2.0-or-later
"""A Modbus device by pymodbus: modbus_server.py tcp PORT | rtu DEVICE.

Device 1 has the holding registers 0 to 9: -15 as s16, milliseconds of the clock as u32 in 1 and 2, 3.5 as f32 with the low
word first in 3 and 4, 0x0308 in 5, and 6 to 9 to write. Its coil 3 and its discrete input 5 are true. Device 7 has -40.
Others do not answer. Nothing has registers from 100 on.
"""

import logging
import sys
import time

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server import StartSerialServer, StartTcpServer

try:
    from pymodbus.transaction import ModbusRtuFramer as RTU  # pymodbus 3.0, of Debian 12
except ImportError:
    from pymodbus.framer import FramerType

    RTU = FramerType.RTU

logging.disable(logging.CRITICAL)


class Living(ModbusSequentialDataBlock):
    def getValues(self, address, count=1):
        now = int(time.monotonic() * 1000) % 2**32
        self.values[1], self.values[2] = now >> 16, now & 0xFFFF
        return super().getValues(address, count)


def device(values):
    def blocks(first):
        return {
            "hr": Living(first, values),
            "ir": ModbusSequentialDataBlock(first, [235] * 10),
            "co": ModbusSequentialDataBlock(first, [0, 0, 0, 1, 0, 0, 0, 0]),
            "di": ModbusSequentialDataBlock(first, [0, 0, 0, 0, 0, 1, 0, 0]),
        }

    try:
        return ModbusSlaveContext(zero_mode=True, **blocks(0))
    except TypeError:  # later versions count from 1
        return ModbusSlaveContext(**blocks(1))


CONTEXT = ModbusServerContext(
    slaves={1: device([65536 - 15, 0, 0, 0, 0x4060, 0x0308, 0, 0, 0, 0]), 7: device([65536 - 40] + [0] * 9)}, single=False
)

if __name__ == "__main__":
    if sys.argv[1] == "tcp":
        address = ("127.0.0.1", int(sys.argv[2]))
        try:
            StartTcpServer(context=CONTEXT, address=address, allow_reuse_address=True)
        except TypeError:  # later versions do so by themselves
            StartTcpServer(context=CONTEXT, address=address)
    else:
        StartSerialServer(context=CONTEXT, framer=RTU, port=sys.argv[2], baudrate=19200, parity="N", timeout=0.02, ignore_missing_slaves=True)
