"""Python tools of godobject. `godobject.hil`: hardware-in-the-loop tests."""
