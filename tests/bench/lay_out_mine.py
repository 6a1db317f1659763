#!/usr/bin/env python3
"""Lays a mine out at random of the tiles that the DARPA Subterranean Challenge's simulator is built of, and writes it as a Gazebo world.

usage: lay_out_mine.py KIND SEED > OUT.world

KIND: cave        a grid of natural caves, ten kinds of tile in any order and heading
      few_kinds   the same of four kinds, so that places repeat
      rough       tunnels of rough rock that grow from a crossing: straights, corners, crossings, ramps, loops and dead ends
      smooth      the same of smooth tiles
      mixed       the same of both
The same kind and seed give the same mine. A robot can start at 0,0 (in a cave) or 0,0,1 (in tunnels). Only the names and the grid of the tiles are
used here; the tiles themselves are models of that simulator."""
import math
import random
import sys

TILE = 20.0  # metres, the edge of every tile
STEP = 5.0  # metres by which a ramp rises
EAST, NORTH, WEST, SOUTH = range(4)  # headings, each a quarter turn from the one before
OFFSET = {EAST: (1, 0), NORTH: (0, 1), WEST: (-1, 0), SOUTH: (0, -1)}
# What a tile joins with yaw 0: {heading: metres above the tile's own floor}.
CROSSING = {EAST: 0.0, NORTH: 0.0, WEST: 0.0, SOUTH: 0.0}
STRAIGHT = {NORTH: 0.0, SOUTH: 0.0}
CORNER = {EAST: 0.0, SOUTH: 0.0}
RAMP = {NORTH: STEP, SOUTH: 0.0}
ROUGH = [("rough_tunnel_tile_straight", STRAIGHT, 8), ("rough_tunnel_tile_90deg_turn", CORNER, 4),
         ("rough_tunnel_tile_4way_intersection", CROSSING, 3), ("rough_tunnel_tile_ramp", RAMP, 1)]
SMOOTH = [("tunnel_tile_5", STRAIGHT, 8), ("tunnel_tile_2", CORNER, 4), ("tunnel_tile_1", CROSSING, 3),
          ("tunnel_tile_6", RAMP, 1)]  # the simulator's constrained tiles are too low, and tunnel_tile_7 is too steep, for the robots that drive
TUNNELS = {"rough": ROUGH, "smooth": SMOOTH, "mixed": ROUGH + SMOOTH}
TUNNEL_TILES = 40  # tiles of a tunnel mine, dead ends not counted
CAVE_COLUMNS, CAVE_ROWS = 9, 5


def cave(rng, kinds):
    """Every tile of the grid at any heading: they all open to all sides."""
    tiles = rng.sample(range(1, 11), kinds)
    return [(f"cave_tile_{rng.choice(tiles)}", x * TILE, y * TILE, 0.0, rng.randrange(4) * math.pi / 2)
            for x in range(-(CAVE_COLUMNS // 2), CAVE_COLUMNS // 2 + 1) for y in range(-(CAVE_ROWS // 2), CAVE_ROWS // 2 + 1)]


def turned(openings, quarter_turns):
    return {(heading + quarter_turns) % 4: rise for heading, rise in openings.items()}


def tunnels(rng, pieces):
    """Tunnels grown tile by tile from a crossing at the origin; what stays open at the end is walled off."""
    placed = {}  # cell -> (name, floor, quarter turns, openings)
    frontier = []  # (cell to fill, the heading from which it is entered, floor there)

    def place(cell, name, openings, quarter_turns, floor):
        placed[cell] = (name, floor, quarter_turns, {heading: floor + rise for heading, rise in turned(openings, quarter_turns).items()})
        for heading, level in placed[cell][3].items():
            frontier.append(((cell[0] + OFFSET[heading][0], cell[1] + OFFSET[heading][1]), (heading + 2) % 4, level))

    crossings = [piece for piece in pieces if piece[1] is CROSSING]
    place((0, 0), rng.choice(crossings)[0], CROSSING, 0, 0.0)
    blocked = []
    while frontier:
        cell, entry, level = frontier.pop(rng.randrange(len(frontier)))
        if cell in placed:
            if placed[cell][3].get(entry) != level:  # it has no opening there, or one at another level
                blocked.append((cell, entry, level))
            continue
        if len(placed) >= TUNNEL_TILES:
            blocked.append((cell, entry, level))
            continue
        name, openings, _ = rng.choices(pieces, [weight for _, _, weight in pieces])[0]
        own = rng.choice(list(openings))  # the opening of the tile that meets where we come from
        place(cell, name, openings, (entry - own) % 4, level - openings[own])
    tiles = [(name, x * TILE, y * TILE, floor, turns * math.pi / 2) for (x, y), (name, floor, turns, _) in placed.items()]
    for (x, y), entry, level in blocked:
        dx, dy = OFFSET[entry]
        tiles.append(("tunnel_tile_blocker", (x + dx * 0.5) * TILE, (y + dy * 0.5) * TILE, level, (0.0 if dx else math.pi / 2)))
    return tiles


def world(tiles):
    includes = "\n".join(f"    <include><name>tile_{i}</name><uri>model://{name}</uri><pose>{x:.6f} {y:.6f} {z:.6f} 0 0 {yaw:.6f}</pose></include>"
                         for i, (name, x, y, z, yaw) in enumerate(tiles))
    return f'<?xml version="1.0"?>\n<sdf version="1.6">\n  <world name="laid_out_mine">\n{includes}\n  </world>\n</sdf>\n'


def lay_out(kind, seed):
    """The world of a kind and a seed, or None if there is no such kind."""
    rng = random.Random(f"{kind} {seed}")
    if kind in ("cave", "few_kinds"):
        return world(cave(rng, 10 if kind == "cave" else 4))
    return world(tunnels(rng, TUNNELS[kind])) if kind in TUNNELS else None


def main(arguments):
    laid_out = lay_out(arguments[0], arguments[1]) if len(arguments) == 2 else None
    if laid_out is None:
        print(__doc__ if len(arguments) != 2 else f"lay_out_mine: there is no kind '{arguments[0]}', but: cave, few_kinds, rough, smooth, mixed", file=sys.stderr)
        return 2
    try:
        print(laid_out, end="", flush=True)
    except OSError as error:  # as when the disk is full
        print(f"lay_out_mine: the world cannot be written: {error.strerror}", file=sys.stderr)
        sys.stdout = None  # what is left in its buffer cannot be written either
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
