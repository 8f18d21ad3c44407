"""What is charted. A method or rival is a row of SERIES, and has that row's colour in every chart.

Colours: Okabe and Ito's and Tol's, told apart by colour-blind readers; raster coders are greys."""
from dataclasses import dataclass

from osgeo import gdal

from programs import BENCH, BIN, ROOT

_METER = (BIN / "bench_rivals",)
_SCRIPTS = ROOT / "scripts/benchmarks"
_GDAL = f"GDAL {gdal.__version__}"


@dataclass(frozen=True)
class Series:
    name: str
    kind: str  # tree: tintree-build with `options`; mesh, raster: the rival of this name in scripts/benchmarks
    color: str
    marker: str
    options: tuple = ()
    programs: tuple = ()  # files, and names of libraries with their versions, whose change makes the figures old
    seconds: float = 3  # to expect of a measurement that was never made
    terrains: tuple = ()  # measured on these alone, and
    errors: tuple = ()  # at these errors alone (in sample spacings), where it is too slow for all
    most_samples: float = 1e8  # of trees whose whole build is measured

    @property
    def line(self):
        return {"tree": "-", "mesh": "--", "raster": ":"}[self.kind]


def _tree(name, color, marker, *options, **size):
    programs = (BIN / "tintree-build", BIN / "tintree-export", BIN / "bench_decode", *_METER)
    return Series(name, "tree", color, marker, options, programs, **size)


def _mesh(name, color, marker, *programs, **slow):
    return Series(name, "mesh", color, marker, (), (*programs, *_METER), **slow)


def _raster(name, color, marker):
    return Series(name, "raster", color, marker, (), (_GDAL, _SCRIPTS / "raster_coders.py", _SCRIPTS / "fitting.py", *_METER))


_NODE = (BENCH / "simplify.js", BENCH / "package-lock.json")

SERIES = [
    _tree("tintree fast", "#0072B2", "o", "--effort", "fast", most_samples=1e9),
    _tree("tintree best", "#D55E00", "s", "--effort", "best"),
    _tree("tintree strip", "#332288", "d", "--method", "strip", most_samples=1e9),
    _tree("tintree nested", "#44AA99", "p", "--method", "nested", most_samples=1e9),
    _tree("tintree wavelet", "#AA4499", "H", "--method", "wavelet"),
    _tree("tintree scalar", "#DDCC77", "8", "--method", "scalar"),
    _mesh("delatin", "#009E73", "^", *_NODE),
    _mesh("martini", "#E69F00", "v", *_NODE),
    _mesh("meshoptimizer", "#CC79A7", "D"),
    _mesh("VTK greedy", "#56B4E9", "P", ROOT / "tests/bench/rivals/vtk_greedy.py", seconds=12, errors=(0.2, 1, 4)),
    _mesh("OpenMesh", "#999933", "X", seconds=140, terrains=("california",), errors=(0.5,)),
    _mesh("CGAL Lindstrom-Turk", "#882255", "*", seconds=70, terrains=("california",), errors=(0.5,)),
    _raster("JPEG-LS", "#000000", "<"),
    _raster("JPEG 2000", "#555555", ">"),
    _raster("LERC_ZSTD", "#999999", "h"),
]
#: What the others are compared with in the table: tintree-build as it comes.
BASE = "tintree fast"
