"""scripts/atlas: where simplifiers fail. See scripts/atlas --help."""
import argparse
import sys
import time
from pathlib import Path

import atlas_page
import atlas_pictures
import terrains
from contenders import CONTENDERS, meet, tools_digest
from memo import Memo, digest
from programs import BENCH, CACHE, ROOT
from progress import Progress

MEMO = BENCH / "atlas.jsonl"
LIMIT_S, QUICK_LIMIT_S = 10, 3
TYPICAL_S = 1.5  # of a measurement that was never made


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/atlas", description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", metavar="TERRAIN", action="append")
    parser.add_argument("--draw-only", action="store_true")
    parser.add_argument("--data", default=ROOT.parent / "shared" / "data", type=Path)
    return parser.parse_args()


def chosen(args):
    every = terrains.listed() + terrains.real(args.data)
    unknown = set(args.only or ()) - {t.name for t in every}
    if unknown:
        sys.exit(f"scripts/atlas: {', '.join(sorted(unknown))}: no such terrain; there are {' '.join(t.name for t in every)}")
    names = args.only or (terrains.QUICK if args.quick else [t.name for t in every])
    return [t for t in every if t.name in names]


def map_of(terrain, contender):
    return terrains.FOLDER / f"{terrain.name}.{contender.name.replace(' ', '_')}.f32"


def known(which, latest):
    """{terrain: {method: figures}} of what was measured last."""
    for terrain in which:
        for contender in CONTENDERS:
            if (terrain.name, contender.name) not in latest:
                sys.exit(f"scripts/atlas: {terrain.name} by {contender.name} was never measured; run without --draw-only")
    return {t: {c.name: latest[t.name, c.name] for c in CONTENDERS} for t in which}


def measured(which, args, memo, latest):
    """The same, of these programs on these heights, measured where it is not known."""
    limit_s = QUICK_LIMIT_S if args.quick else LIMIT_S
    rasters = {t: terrains.raster_of(t, args.data) for t in which}
    errors_m = {t: terrains.error_of(t, rasters[t]) for t in which}
    keys = {}
    for terrain, raster in rasters.items():
        fingerprint = digest(terrains.fingerprint(raster))
        for c in CONTENDERS:
            keys[terrain, c] = digest(c.name, repr(errors_m[terrain]), limit_s, fingerprint, tools_digest(c.tools))
    missing = [place for place, key in keys.items() if memo.get(key) is None]
    progress = Progress(len(keys), {(t, c): latest.get((t.name, c.name), {}).get("wall_seconds", TYPICAL_S) for t, c in missing})
    for terrain, contender in missing:
        progress.begin((terrain, contender), f"{terrain.name}, {contender.name}")
        begun = time.monotonic()
        figures = meet(contender, rasters[terrain], errors_m[terrain], map_of(terrain, contender), limit_s)
        print(f"    {atlas_page.said(figures)}", file=sys.stderr, flush=True)
        memo.put(keys[terrain, contender], {"terrain": terrain.name, "method": contender.name, "error_m": errors_m[terrain], **figures,
                                            "wall_seconds": round(time.monotonic() - begun, 3)})
    return {t: {c.name: memo.get(keys[t, c]) for c in CONTENDERS} for t in which}


def main():
    args = arguments()
    CACHE.mkdir(parents=True, exist_ok=True)
    memo = Memo(MEMO)
    latest = {(r["terrain"], r["method"]): r for r in memo.records.values()}
    atlas = known(chosen(args), latest) if args.draw_only else measured(chosen(args), args, memo, latest)

    partly = args.quick or args.only
    page = terrains.FOLDER / "stability.md" if partly else ROOT / "docs" / "stability.md"
    images = page.parent / ("images" if partly else "images/stability")
    images.mkdir(parents=True, exist_ok=True)
    for family in dict.fromkeys(t.family for t in atlas):
        members = {t: rows for t, rows in atlas.items() if t.family == family}
        atlas_pictures.draw(images / f"{family}.png", members, args.data, map_of)
    page.write_text(atlas_page.page(atlas, images.relative_to(page.parent)))
    print(page)
    broken = [f"{t.name} by {m}: {atlas_page.said(r)}" for t, rows in atlas.items() for m, r in rows.items() if atlas_page.breach_of_ours(m, r)]
    if broken:
        sys.exit("scripts/atlas: tintree breaks its own bound:\n  " + "\n  ".join(broken))


try:
    main()
except KeyboardInterrupt:
    print("\nscripts/atlas: stopped; the same command goes on from here", file=sys.stderr)
    sys.exit(5)
