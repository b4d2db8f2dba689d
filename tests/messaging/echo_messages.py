#!/usr/bin/env python3
"""echo_messages.py FOLDER: reads every FOLDER/<package>.<type>.in with lcm-gen's Python bindings, which
lie in FOLDER too; writes what it read to .txt and encodes it again to .out."""

import importlib
import pathlib
import sys

folder = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(folder))
for source in folder.glob("*.in"):
    package, name = source.stem.split(".")
    message_type = getattr(importlib.import_module(f"{package}.{name}"), name)
    message = message_type.decode(source.read_bytes())
    fields = [(field, getattr(message, field)) for field in message.__slots__]
    rounded = lambda v: tuple(round(x, 9) for x in v) if isinstance(v, (tuple, list)) and v and isinstance(
        v[0], float) else v
    source.with_suffix(".txt").write_text("".join(f"{field} {rounded(value)}\n" for field, value in fields))
    source.with_suffix(".out").write_bytes(message.encode())
