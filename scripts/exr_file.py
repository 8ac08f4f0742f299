"""Float channels of the EXR files that `slim render` writes (scan lines, zip, one part), for the benchmarks."""

import array
import struct
import sys
import zlib


def c_string(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def exr_header(data):
    """Channels [(name, type)] in the file's order, (width, height), where the offset table begins."""
    if data[:4] != b"\x76\x2f\x31\x01":
        sys.exit("not an EXR file")
    at, channels, window = 8, [], None
    while data[at] != 0:
        name, at = c_string(data, at)
        _, at = c_string(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        value, at = data[at + 4:at + 4 + size], at + 4 + size
        if name == "channels":
            k = 0
            while value[k] != 0:
                channel, k = c_string(value, k)
                channels.append((channel, struct.unpack_from("<i", value, k)[0]))
                k += 16
        elif name == "dataWindow":
            x0, y0, x1, y1 = struct.unpack("<4i", value)
            window = (x1 - x0 + 1, y1 - y0 + 1)
        elif name == "compression" and value[0] != 3:
            sys.exit("EXR: expected zip compression of 16 rows")
    return channels, window, at + 1


def unzipped(packed, size):
    """A block of rows: differences of bytes, the even ones first (OpenEXR's zip)."""
    if len(packed) == size:
        return packed
    raw = bytearray(zlib.decompress(packed))
    for i in range(1, size):
        raw[i] = (raw[i - 1] + raw[i] - 128) & 255
    out, half = bytearray(size), (size + 1) // 2
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return bytes(out)


def read_exr(path, wanted):
    """{name: array of floats, row by row} of the float channels wanted, width, height."""
    data = path.read_bytes()
    channels, (width, height), table = exr_header(data)
    planes = {name: array.array("f", bytes(4 * width * height)) for name in wanted}
    row_bytes = sum(width * (2 if kind == 1 else 4) for _, kind in channels)
    for block in range((height + 15) // 16):
        start = struct.unpack_from("<Q", data, table + 8 * block)[0]
        first, size = struct.unpack_from("<ii", data, start)
        rows = min(16, height - first)
        raw = unzipped(data[start + 8:start + 8 + size], rows * row_bytes)
        at = 0
        for y in range(first, first + rows):
            for name, kind in channels:
                n = width * (2 if kind == 1 else 4)
                if name in planes:
                    planes[name][y * width:(y + 1) * width] = array.array("f", raw[at:at + n])
                at += n
    return planes, width, height
