"""SLCAN on a terminal for python-can. The slcan interface of python-can 4.1 needs three system calls per byte,
which is too slow for a rig."""
import os
import re
import select
import time
import tty

import can

FRAME = re.compile(rb"t([0-9A-Fa-f]{3})([0-8])((?:[0-9A-Fa-f]{2})*)$|T([0-9A-Fa-f]{8})([0-8])((?:[0-9A-Fa-f]{2})*)$")


class SlcanBus(can.BusABC):
    """Data frames of an adapter or of a godobject pty. bit_rate_code: S0 to S8, 8 is 1 Mbit/s."""

    def __init__(self, channel, bit_rate_code=8, **kwargs):
        self.channel_info = f"slcan {channel}"
        self._fd = os.open(channel, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self._fd)
        self._text = b""
        self._messages = []
        os.write(self._fd, b"\rC\rS%d\rO\r" % bit_rate_code)
        super().__init__(channel, **kwargs)

    def _take(self, lines, now):
        for line in lines:
            match = FRAME.search(line.rpartition(b"\a")[2])  # a refusal is a BEL without CR
            if not match:
                continue
            cob_id, _, data, extended_id, _, extended_data = match.groups()
            self._messages.append(can.Message(
                timestamp=now, arbitration_id=int(cob_id or extended_id, 16), is_extended_id=cob_id is None,
                data=bytes.fromhex((data if cob_id else extended_data).decode())))

    def _recv_internal(self, timeout):
        if not self._messages and select.select([self._fd], [], [], timeout)[0]:
            *lines, self._text = (self._text + os.read(self._fd, 65536)).split(b"\r")
            self._take(lines, time.time())
        return (self._messages.pop(0) if self._messages else None), False

    def send(self, msg, timeout=None):
        kind = b"T%08X" if msg.is_extended_id else b"t%03X"
        os.write(self._fd, kind % msg.arbitration_id + b"%d" % msg.dlc + msg.data.hex().upper().encode() + b"\r")

    def shutdown(self):
        super().shutdown()
        try:
            os.write(self._fd, b"C\r")
        except OSError:  # the other end is gone already
            pass
        os.close(self._fd)
