"""Which charts there are: a chart is a row of panels for each error measure, a column for each terrain; or panels side by side
of one terrain."""
from dataclasses import dataclass
from typing import Callable

MIB = 1 / (1 << 20)


@dataclass(frozen=True)
class Axis:
    label: str
    value: Callable  # record -> number, or None where the record has none


def _field(name, factor=1.0):
    return lambda record: record[name] * factor if record.get(name) else None


def _per_sample(name, factor):
    return lambda record: record[name] * factor / record["samples"]


@dataclass(frozen=True)
class Panel:
    kind: str  # of the records
    x: Axis
    y: Axis
    front: bool = True  # mark what no other beats
    unity: bool = False  # a line at y = 1


@dataclass(frozen=True)
class Chart:
    name: str
    title: str
    about: str
    panels: tuple
    terrain: str = ""  # the panels side by side, of this one alone

    @property
    def file(self):
        return f"{self.name}.svg"


MAXIMUM = Axis("largest error at samples, m", _field("samples_max_m"))
RMS = Axis("RMS error, m", _field("rms_m"))
ASKED = Axis("error asked for, m", _field("asked_m"))


def _against_errors(name, title, about, y, kind="level"):
    return Chart(name, title, about, (Panel(kind, MAXIMUM, y), Panel(kind, RMS, y)))


BYTES = Axis("bytes a sample", _field("bytes_per_sample"))
BUILD = Axis("making it, processor s", _field("seconds"))
DECODE = Axis("reading it, processor ms", _field("decode_seconds", 1e3))
SAMPLES = Axis("millions of samples", _field("samples", 1e-6))
FRAME = Axis("drawing it, processor ms a frame", _field("frame_seconds", 1e3))

CHARTS = {chart.name: chart for chart in (
    Chart("overview", "All methods at a glance: the Sierra Nevada", "One level of one terrain against its largest error; the charts below "
          "say how each is measured.",
          (Panel("level", MAXIMUM, BYTES), Panel("level", MAXIMUM, BUILD), Panel("level", MAXIMUM, DECODE), Panel("frame", MAXIMUM, FRAME)),
          terrain="california"),
    _against_errors("bytes", "Bytes", "One level of the terrain: of a tree its leaves as stored, of other meshes the same coder "
                    "(Draco) over the whole mesh, of rasters the coded file.", BYTES),
    _against_errors("vertices", "Vertices", "Of the same meshes; raster coders have none.", Axis("vertices", _field("vertices"))),
    _against_errors("build", "Making it", "Processor seconds of one thread: of the simplification or coding alone (JPEG 2000: of the "
                    "last step of its search), of a tree its leaves' share of the whole build, reading and measuring included.", BUILD),
    _against_errors("decode", "Reading it", "Processor time: of a tree's leaves from file to checked meshes, of other meshes Draco's, "
                    "of rasters GDAL's (JPEG-LS: CharLS's). The least of several.", DECODE),
    _against_errors("frame", "Drawing it", "Processor time of all threads for a picture of 1280 x 720 pixels of the whole level, drawn "
                    "in software (llvmpipe) by tintree-view, which draws trees alone.",
                    FRAME, kind="frame"),
    Chart("screen", "Error on the screen against time", "The same picture at --pixel-error 0.25 to 8, of trees within a tenth of a "
          "sample spacing in tiles of 64 cells. The error is the largest that a drawn tile has.",
          (Panel("view", FRAME, Axis("largest error, pixels", _field("max_error_px"))),)),
    Chart("memory", "Memory against the error allowed", "Largest resident memory of the program that makes the level (rasters: not "
          "measured, they are coded inside the benchmark), and of tintree-view with software OpenGL.",
          (Panel("level", ASKED, Axis("making it, MiB", _field("peak_rss_bytes", MIB)), front=False),
           Panel("view", Axis("pixel error allowed", _field("pixel_error")), Axis("drawing it, MiB", _field("view_peak_rss_bytes", MIB)), front=False))),
    Chart("promise", "What the error asked for is worth", "The error that the result really has over the one asked for: at the samples, "
          "which is what most look at, and over the whole surface. Above the line it is broken.",
          (Panel("level", ASKED, Axis("at samples / asked", lambda r: r["samples_max_m"] / r["asked_m"] or None), front=False, unity=True),
           Panel("level", ASKED, Axis("of surface / asked", lambda r: r["surface_max_m"] / r["asked_m"] or None), front=False, unity=True))),
    Chart("size", "Cost against size: the Moon and its mirror images", "Whole builds of all levels, measured and packed, at the default error and "
          "--memory 1024: what costs no more than the input runs level. Rasters of more than 67 M samples are read through a VRT over four compressed files.",
          (Panel("size", SAMPLES, Axis("processor s a million samples", _per_sample("cpu_seconds", 1e6)), front=False),
           Panel("size", SAMPLES, Axis("bits of the file a sample", _per_sample("tree_bytes", 8)), front=False),
           Panel("size", SAMPLES, Axis("wall clock, two threads, s", _field("wall_s")), front=False),
           Panel("size", SAMPLES, Axis("peak memory, MiB", _field("peak_rss_bytes", MIB)), front=False)),
          terrain="moon"),
)}


def points(panel, records, data):
    """{series: [(x, y)] in order of x} of one terrain."""
    out = {}
    for record in records:
        if record["kind"] != panel.kind or record["data"] != data:
            continue
        x, y = panel.x.value(record), panel.y.value(record)
        if x and y:
            out.setdefault(record["series"], []).append((x, y))
    return {series: sorted(values) for series, values in out.items()}
