"""The most memory a process had, for programs that tests run in a process of their own.

Not ``ru_maxrss``: a new process begins with that of the one that started it, however large that was.
"""

from __future__ import annotations

MOST = """
def most():
    with open("/proc/self/status", encoding="ascii") as told:
        (size,) = (line.split()[1] for line in told if line.startswith("VmHWM:"))
    return 1024 * int(size)
"""
"""Program text: ``most()`` returns bytes."""
