"""What drawing costs."""
import json

from programs import BENCH, BIN, run

PROGRAMS = (BIN / "tintree-view",)
SIZE = "1280x720"


def frame(tree, pixel_error):
    """The tree from the viewer's own first viewpoint, the whole terrain from the south, in software (llvmpipe): processor
    seconds of a picture whose tiles are there, error on the screen, and the viewer's memory."""
    report = BENCH / "charts" / "view.json"
    cost = run(BIN / "tintree-view", tree, "--headless", "osmesa", "--size", SIZE, "--pixel-error", repr(pixel_error),
               "--json", report, "--quiet")
    drawn = json.loads(report.read_text())
    return {"frame_seconds": drawn["redraw_cpu_seconds"], "max_error_px": drawn["max_error_px"], "triangles": drawn["triangles"],
            "tiles": drawn["tiles"], "view_peak_rss_bytes": cost.peak_rss_bytes, "command": cost.command}
