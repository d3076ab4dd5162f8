"""Reader of uncompressed and ZIP-compressed float OpenEXR files, independent of the renderer."""

import struct
import zlib

import numpy as np


def _attributes(data, at):
    """Yields name and value of the header's attributes, then the offset after the header."""
    attributes = {}
    while data[at] != 0:
        end = data.index(0, at)
        name, at = data[at:end].decode(), end + 1
        at = data.index(0, at) + 1
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _unzip(block):
    """Undoes ZIP compression of OpenEXR: differences of bytes, whose halves are interleaved."""
    raw = np.frombuffer(zlib.decompress(block), dtype=np.uint8).astype(np.int64)
    raw[1:] -= 128
    raw = (np.cumsum(raw) % 256).astype(np.uint8)
    half = (len(raw) + 1) // 2
    out = np.empty_like(raw)
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return out.tobytes()


def read(path):
    """Returns the channels of a scan-line file with float channels, by name."""
    data = path.read_bytes()
    assert struct.unpack_from("<i", data)[0] == 20000630, "no OpenEXR file"
    attributes, at = _attributes(data, 8)
    channels, position = [], 0
    while attributes["channels"][position] != 0:
        end = attributes["channels"].index(0, position)
        channels.append(attributes["channels"][position:end].decode())
        assert struct.unpack_from("<i", attributes["channels"], end + 1)[0] == 2, "not float"
        position = end + 17
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    compression = attributes["compression"][0]
    rows = {0: 1, 2: 1, 3: 16}[compression]
    blocks = -(-height // rows)
    image = {name: np.empty((height, width), np.float32) for name in channels}
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        block = data[offset + 8 : offset + 8 + size]
        lines = min(rows, height - (y - top))
        if compression and size < lines * width * 4 * len(channels):
            block = _unzip(block)
        values = np.frombuffer(block, "<f4").reshape(lines, len(channels), width)
        for i, name in enumerate(channels):
            image[name][y - top : y - top + lines] = values[:, i]
    return image
