#!/usr/bin/env python3
"""extract_vmlinux.py VMLINUZ VMLINUX: the ELF kernel inside a compressed one.

QEMU starts it directly (PVH), which saves decompressing it in the guest: seconds, without KVM.
"""
import lzma
import sys

XZ_MAGIC = b"\xfd7zXZ\0"


def elf_inside(image: bytes) -> bytes:
    start = image.find(XZ_MAGIC)
    while start >= 0:
        try:
            # A decompressor, unlike lzma.decompress, puts up with what follows the stream.
            kernel = lzma.LZMADecompressor().decompress(image[start:])
            if kernel.startswith(b"\x7fELF"):
                return kernel
        except lzma.LZMAError:
            pass
        start = image.find(XZ_MAGIC, start + 1)
    sys.exit(f"{sys.argv[1]}: no xz-compressed ELF kernel inside")


if __name__ == "__main__":
    source, target = sys.argv[1:]
    with open(source, "rb") as f:
        kernel = elf_inside(f.read())
    with open(target, "wb") as f:
        f.write(kernel)
