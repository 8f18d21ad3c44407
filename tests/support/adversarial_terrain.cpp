#include "tests/support/adversarial_terrain.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <utility>

namespace tintree::test {
namespace {

double islands(int c, int r) {
  return (c % 5 < 2 && r % 5 < 2 && !(c % 5 == 0 && r % 5 == 1)) ? hills(c, r) : kMissing;
}

double corrugation(int k) { return std::abs(k % 4 - 2); }

/// An odd number of sixteenths: halfway between multiples of an eighth, a quarter of an error of half a metre.
double tie(int c, int r, unsigned seed) { return std::floor((noise(c, r, seed) - 0.5) * 64) / 8 + 1.0 / 16; }

std::vector<AdversarialTerrain> planes_and_edges() {
  return {
      {"flat", "all samples equal, and all costs", 129, 130, [](int, int) { return 12.0; }},
      {"slope", "a plane that every lattice of heights holds", 129, 130,
       [](int c, int r) { return 0.5 * c - 0.25 * r; }},
      {"slope_off_lattice", "a plane that no lattice of heights holds", 129, 129,
       [](int c, int r) { return 0.1 * c + 0.037 * r + 0.013; }},
      {"steep_slope", "a steep plane", 65, 65, [](int c, int r) { return 60.0 * c + 35.0 * r; }},
      {"cliff", "a cliff across the grid's directions", 129, 130,
       [](int c, int r) { return c + r / 3 > 77 ? 300.0 : 0.0; }},
      {"steps", "cliffs along columns", 129, 65, [](int c, int) { return 25.0 * (c / 7); }},
      {"terraces", "hills counted in threes", 129, 129, [](int c, int r) { return 3.0 * std::floor(hills(c, r) / 3); }},
      {"eight_bit", "hills in 256 steps of a metre, flat terraces without end", 65, 65,
       [](int c, int r) { return std::floor(128 + hills(c / 3, r / 3, 127)); }},
      {"checkerboard", "ups and downs at the sample frequency", 65, 66,
       [](int c, int r) { return (c + r) % 2 == 0 ? 10.0 : 0.0; }},
      {"corrugation", "pleats both ways: the same cost everywhere", 65, 65,
       [](int c, int r) { return corrugation(c) + corrugation(r); }},
      {"rounding_ties", "every height halfway between two lattice heights, around 0", 65, 65,
       [](int c, int r) { return tie(c, r, 1); }},
      {"smooth_ties", "hills whose heights all lie halfway between two lattice heights", 65, 65,
       [](int c, int r) { return std::floor(hills(c, r) * 8) / 8 + 1.0 / 16; }},
  };
}

std::vector<AdversarialTerrain> shapes() {
  return {
      {"white_noise", "no two samples have to do with each other", 65, 65,
       [](int c, int r) { return 100 * noise(c, r); }},
      {"spike", "one sample far above a plain", 129, 129,
       [](int c, int r) { return c == 77 && r == 70 ? 500.0 : 0.0; }},
      {"pit", "one sample far below a plain, where four tiles meet", 129, 129,
       [](int c, int r) { return c == 64 && r == 64 ? -500.0 : 0.0; }},
      {"saddle", "a saddle: planar along rows and columns, nowhere else", 129, 129,
       [](int c, int r) { return (c - 64) * (r - 64) / 32.0; }},
      {"saddles", "a saddle in every 16 cells", 65, 65, [](int c, int r) { return (c % 16 - 8) * (r % 16 - 8) / 4.0; }},
      {"ridges", "knife-edged ridges along no direction of the grid", 129, 129,
       [](int c, int r) { return 6 * std::abs(std::remainder(c + 0.4 * r, 16)); }},
      {"hills", "smooth over all", 257, 257, [](int c, int r) { return hills(c, r, 40); }},
      {"far_above", "hills high up", 65, 65, [](int c, int r) { return 8000 + hills(c, r); }},
      {"ribbon", "many tiles in a row, each cut", 1000, 7, rough_hills(20, 2, 0.01)},
      {"odd", "whose size no tile divides", 150, 101, rough_hills(30, 1, 0.001)},
      {"two_by_two", "one cell", 2, 2, [](int c, int r) { return c + 5.0 * r; }},
      {"one_row", "one row of cells", 70, 2, [](int c, int r) { return hills(c, r) + 9 * r; }},
  };
}

std::vector<AdversarialTerrain> holes() {
  return {
      {"nodata_checkerboard", "every other sample missing: no triangle at all", 65, 66,
       [](int c, int r) { return (c + r) % 2 == 0 ? hills(c, r) : kMissing; }},
      {"nodata_lattice", "every fourth sample missing: lone triangles that touch at corners", 65, 66,
       [](int c, int r) { return c % 2 == 1 && r % 2 == 1 ? kMissing : hills(c, r); }},
      {"nodata_squares", "a checkerboard of squares of 4 x 4 samples", 65, 66,
       [](int c, int r) { return (c / 4 + r / 4) % 2 == 0 ? hills(c, r) : kMissing; }},
      {"nodata_pinches", "a checkerboard of squares that touch at corners", 65, 66,
       [](int c, int r) { return c % 4 != 0 && r % 4 != 0 && (c / 4 + r / 4) % 2 == 1 ? kMissing : hills(c, r); }},
      {"nodata_stripes", "strips one cell wide", 97, 65,
       [](int c, int r) { return c % 3 == 2 ? kMissing : hills(c, r); }},
      {"holes_5", "one sample in twenty missing", 129, 130, rough_hills(20, 1, 0.05)},
      {"holes_30", "three samples in ten missing", 129, 129, rough_hills(20, 1, 0.3)},
      {"holes_60", "more holes than ground", 129, 65, rough_hills(20, 1, 0.6)},
      {"flat_with_holes", "a plain with square holes", 129, 130,
       [](int c, int r) { return noise(c / 3, r / 3, 5) < 0.2 ? kMissing : 1.0; }},
      {"islands", "small shapes apart from each other", 129, 129, islands},
      {"frame", "nothing but the middle", 129, 129,
       [](int c, int r) {
         return std::min({c, r, 128 - c, 128 - r}) < 9 ? kMissing : hills(c, r);
       }},
      {"lone_triangle", "three samples", 65, 65,
       [](int c, int r) { return c >= 31 && c <= 32 && r >= 31 && r <= 32 && c - r < 1 ? 5.0 * c - r : kMissing; }},
      {"two_by_two_holed", "one triangle", 2, 2, [](int c, int r) { return c == 1 && r == 0 ? kMissing : 3.0 * c; }},
  };
}

std::vector<AdversarialTerrain> extremes() {
  std::vector<AdversarialTerrain> out{
      {"million_above", "millimetres at a height of a million metres", 65, 65,
       [](int c, int r) { return 1e6 + hills(c, r, 0.02) + 0.001 * noise(c, r); }},
      {"million_below", "millimetres at a depth of a million metres", 65, 65,
       [](int c, int r) { return -1e6 + hills(c, r, 0.02) + 0.001 * noise(c, r); }},
      {"million_apart", "millimetres above and below a cliff of two million metres", 65, 65,
       [](int c, int r) { return (c + r / 2 < 50 ? -1e6 : 1e6) + 0.003 * noise(c, r); }},
      {"plateaus_apart", "two plateaus four million metres apart, with a hole between", 330, 40,
       [](int c, int r) { return c > 250 && c < 260 ? kMissing : (c < 256 ? 0 : 4e6) + hills(c, r, 3); }},
      {"wall", "a plane as steep as a wall", 65, 65, [](int c, int r) { return 1e4 * c - 7e3 * r; }},
      {"rough_wall", "hills on a plane as steep as a wall", 65, 65,
       [](int c, int r) { return 1e4 * c - 7e3 * r + hills(c, r, 100); }},
      {"gentle_slope", "a plane that rises less than the height lattice's step over a tile", 129, 129,
       [](int c, int r) { return 1e-4 * c + 3e-5 * r; }},
      {"cliff_at_block", "a cliff of ten kilometres on column 256", 300, 40,
       [](int c, int r) { return (c < 256 ? 0 : 1e4) + hills(c, r, 3); }},
      {"tiny_spacing", "hills of a millimetre, sampled every hundredth of one", 65, 65,
       [](int c, int r) { return hills(c, r, 1e-3); }, 1e-5},
      {"tiny_spacing_steep", "hills of metres, sampled every hundredth of a millimetre", 65, 65,
       [](int c, int r) { return hills(c, r, 50); }, 1e-5},
      {"tiny_spacing_degrees", "hills sampled every hundred-thousandth of a degree", 65, 65,
       [](int c, int r) { return hills(c, r, 20); }, 1e-5, 4326},
      {"huge_spacing", "continents sampled every thousand kilometres", 65, 65,
       [](int c, int r) { return hills(c, r, 5000); }, 1e6},
      {"micrometres", "a polished surface: micrometres at a height of 70 cm", 65, 65,
       [](int c, int r) { return 0.7 + hills(c, r, 1e-6) + 1e-7 * noise(c, r); }, 1e-6},
  };
  for (AdversarialTerrain& t : out) t.everyday = false;
  return out;
}

}  // namespace

const std::vector<AdversarialTerrain>& adversarial_terrains() {
  static const std::vector<AdversarialTerrain> all = [] {
    std::vector<AdversarialTerrain> out;
    for (const auto& [family, terrains] : {std::pair{"planes", planes_and_edges()},
                                           {"shapes", shapes()},
                                           {"holes", holes()},
                                           {"extremes", extremes()}}) {
      for (AdversarialTerrain t : terrains) {
        t.family = family;
        out.push_back(std::move(t));
      }
    }
    return out;
  }();
  return all;
}

std::vector<AdversarialTerrain> everyday_terrains() {
  std::vector<AdversarialTerrain> out;
  std::ranges::copy_if(adversarial_terrains(), std::back_inserter(out), &AdversarialTerrain::everyday);
  return out;
}

std::optional<AdversarialTerrain> find_terrain(const std::string& name) {
  const std::string random = "random_";
  if (name.starts_with(random) && name.size() > random.size() && name.size() < random.size() + 9 &&
      std::all_of(name.begin() + static_cast<std::ptrdiff_t>(random.size()), name.end(),
                  [](char c) { return c >= '0' && c <= '9'; })) {
    return random_terrain(static_cast<unsigned>(std::stoul(name.substr(random.size()))));
  }
  const auto& all = adversarial_terrains();
  const auto at = std::ranges::find(all, name, &AdversarialTerrain::name);
  return at == all.end() ? std::nullopt : std::optional(*at);
}

void write_terrain(const std::string& path, const AdversarialTerrain& terrain) {
  const RasterSpec spec{.columns = terrain.columns,
                        .rows = terrain.rows,
                        .dx = terrain.spacing,
                        .dy = terrain.spacing,
                        .west = terrain.epsg == 4326 ? 7.0 : 1000.0,
                        .north = terrain.epsg == 4326 ? 46.0 : 2000.0,
                        .epsg = terrain.epsg};
  write_raster(path, spec, terrain.height);
}

}  // namespace tintree::test
