#pragma once

#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/support/test_raster.h"

namespace tintree::test {

/// A DEM made to find where simplifiers fail. Deterministic; heights in metres, kMissing for none.
struct AdversarialTerrain {
  std::string name;   ///< Unique: lower case, digits and underscores.
  std::string about;  ///< What it is and what it may break.
  int columns = 2;
  int rows = 2;
  HeightFunction height;
  double spacing = 1;    ///< Pixel size in the units of the CRS.
  int epsg = 32610;      ///< 4326 counts in degrees; 0: no CRS.
  bool everyday = true;  ///< Spacing 1 m and heights that every error from 1 cm to 1 km suits.
  std::string family{};  ///< planes, shapes, holes or extremes.

  /// By its name, in the names of tests.
  friend std::ostream& operator<<(std::ostream& out, const AdversarialTerrain& t) { return out << t.name; }
};

/// All of them; a few thousand samples each.
const std::vector<AdversarialTerrain>& adversarial_terrains();

/// The everyday ones.
std::vector<AdversarialTerrain> everyday_terrains();

/// Up to 70 x 70 samples, drawn from the seed: a random walk with spikes, steps, lattice ties and holes, of any scale.
AdversarialTerrain random_terrain(unsigned seed);

/// By name; random_7 is random_terrain(7). Nothing when there is none.
std::optional<AdversarialTerrain> find_terrain(const std::string& name);

/// Writes it as a GeoTIFF of doubles with nodata -9999; throws std::runtime_error when GDAL cannot.
void write_terrain(const std::string& path, const AdversarialTerrain& terrain);

}  // namespace tintree::test
