#!/usr/bin/python3
"""arrows.py SOURCE: includes go down the floors that a rooms.txt states, for each house that has one. Names every arrow that
runs up or sideways."""

import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
include = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def read_floors(page):
    """Height of each room, and the rooms of headers that are not in a room's folder."""
    heights, homes = {}, {}
    rooms = [line for line in page.read_text().splitlines() if line.strip() and not line.startswith("#")]
    for height, line in enumerate(reversed(rooms)):
        names, _, rest = line.partition(":")
        for name in names.split():
            heights[name] = height
            for header in rest.partition("|")[2].split():
                homes[header] = name
    return heights, homes


def house(top, folder, public):
    """Counts the arrows of one house; returns those that are wrong, in words."""
    heights, homes = read_floors(top / "rooms.txt")
    wrong, arrows = [], 0
    rooms = sorted(p.name for p in folder.iterdir() if p.is_dir() and any(p.glob("*.cpp")) | any(p.glob("*.hpp")))
    for room in rooms:
        if room not in heights:
            wrong.append(f"{folder / room} stands on no floor of {top / 'rooms.txt'}")
    for room in heights.keys() - set(rooms):
        wrong.append(f"{top / 'rooms.txt'} names '{room}', which is no folder of {folder}")

    def room_of_header(name):
        first, _, rest = name.partition("/")
        if rest and first in heights:
            return first
        if public and name.startswith(public):
            stem = pathlib.Path(name).stem
            return homes.get(stem) or next((r for r in rooms if (folder / r / f"{stem}.cpp").exists()), None)
        return None

    files = [(p, p.parent.name) for room in rooms for p in (folder / room).iterdir()]
    if public:
        for header in sorted((top / "include" / public).glob("*.hpp")):
            room = room_of_header(public + header.name)
            if room is None:
                wrong.append(f"{header}: no room has a source of that name; say in {top / 'rooms.txt'} where it belongs")
            else:
                files.append((header, room))
    for path, room in files:
        if path.suffix not in (".cpp", ".hpp") or room not in heights:
            continue
        for name in include.findall(path.read_text()):
            to = room_of_header(name)
            if to is None or to == room:
                continue
            arrows += 1
            if heights[to] >= heights[room]:
                wrong.append(f"{path}: '{room}' may not use '{name}' of '{to}'")
    print(f"{folder}: {len(rooms)} rooms, {arrows} arrows")
    return wrong


wrong = house(source / "core", source / "core" / "src", "tendril/")
if (source / "app" / "rooms.txt").exists():
    wrong += house(source / "app", source / "app" / "src", "tendril/app/")
if (source / "bench" / "rooms.txt").exists():
    wrong += house(source / "bench", source / "bench", "")
for line in wrong:
    print(line.replace(str(source) + "/", ""))
sys.exit(1 if wrong else 0)
