"""scripts/atlas: where simplifiers fail. See scripts/atlas --help."""
import argparse
import sys
from pathlib import Path

import atlas_page
import atlas_pictures
import terrains
from contenders import CONTENDERS, meet, tools_digest
from memo import Memo, digest
from programs import BENCH, CACHE, ROOT

MEMO = BENCH / "atlas.jsonl"
LIMIT_S, QUICK_LIMIT_S = 10, 3


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


def rows_of(terrain, args, memo, latest):
    """{method: figures} of one terrain, measured where they are not known."""
    raster = terrains.raster_of(terrain, args.data)
    error_m, fingerprint, rows = terrains.error_of(terrain, raster), terrains.fingerprint(raster), {}
    limit_s = QUICK_LIMIT_S if args.quick else LIMIT_S
    for contender in CONTENDERS:
        if args.draw_only:
            record = latest.get((terrain.name, contender.name))
        else:
            key = digest(contender.name, repr(error_m), limit_s, fingerprint, tools_digest(contender.tools))
            record = memo.get(key)
            if record is None:
                figures = meet(contender, raster, error_m, map_of(terrain, contender), limit_s)
                print(f"  {terrain.name}, {contender.name}: {atlas_page.said(figures)}", file=sys.stderr, flush=True)
                record = memo.put(key, {"terrain": terrain.name, "method": contender.name, "error_m": error_m, **figures})
        if record is None:
            sys.exit(f"scripts/atlas: {terrain.name} by {contender.name} was never measured; run without --draw-only")
        rows[contender.name] = record
    return rows


def main():
    args = arguments()
    CACHE.mkdir(parents=True, exist_ok=True)
    memo = Memo(MEMO)
    latest = {(r["terrain"], r["method"]): r for r in memo.records.values()}
    atlas = {t: rows_of(t, args, memo, latest) for t in chosen(args)}

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


main()
