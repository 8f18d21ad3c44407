#include "cache/manifest.h"

#include <cmath>
#include <filesystem>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/mesh_codec.h"
#include "codec/node_image.h"

namespace tintree::cache {
namespace {

using nlohmann::json;

bool axes_are_sane(const codec::GridAxes& axes) {
  const auto unit = [](const std::array<double, 2>& v) { return std::abs(std::hypot(v[0], v[1]) - 1) < 1e-6; };
  return unit(axes.column) && unit(axes.row) && axes.column[0] * axes.row[1] - axes.column[1] * axes.row[0] < -1e-6;
}

bool layout_is_sane(const codec::TreeLayout& l, const std::string& method) {
  const bool size_ok =
      l.columns >= 2 && l.rows >= 2 && l.columns <= (std::int64_t{1} << 40) && l.rows <= (std::int64_t{1} << 40);
  const bool tile_ok = l.tile_cells >= 1 && l.tile_cells <= (1 << 16) && (l.tile_cells & (l.tile_cells - 1)) == 0;
  if (!size_ok || !tile_ok) return false;
  if (l.leaf_level < 0 || l.leaf_level > codec::kMaxLevel) return false;
  if (l.levels_per_doubling < 1 || l.levels_per_doubling > codec::most_levels_per_doubling(method)) return false;
  if (l.leaf_level != codec::TreeLayout::leaf_level_for(l.columns, l.rows, l.tile_cells, l.levels_per_doubling))
    return false;
  if (l.z_step_m.size() != static_cast<std::size_t>(l.leaf_level) + 1) return false;
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  for (const double step : l.z_step_m) {
    if (!positive(step)) return false;
  }
  return positive(l.dx_m) && positive(l.dy_m) && axes_are_sane(l.axes) && positive(l.leaf_error_m);
}

/// Paths are bytes: one that is no UTF-8 is kept as well as JSON can.
std::string printable(const json& j) { return j.dump(-1, ' ', false, json::error_handler_t::replace); }

constexpr const char* kHole = "hole";
constexpr const char* kFill = "fill";

const char* nodata_name(NodataPolicy nodata) { return nodata == NodataPolicy::kFill ? kFill : kHole; }

std::string differ(const char* what, const auto& there, const auto& here) {
  return there == here ? std::string() : fmt::format("{}: {} there, {} here", what, there, here);
}

/// In how many files, or in which file's name, the inputs differ; folders do not count.
std::string other_files(const std::vector<InputFile>& there, const std::vector<InputFile>& here) {
  if (there.size() != here.size()) return differ("number of input files", there.size(), here.size());
  for (std::size_t i = 0; i < there.size(); ++i) {
    const auto name = [i](const std::vector<InputFile>& files) {
      return printable(std::filesystem::path(files[i].path).filename().string());
    };
    if (name(there) != name(here)) {
      return differ(fmt::format("input file {}", i + 1).c_str(), name(there), name(here));
    }
  }
  return {};
}

/// The first photo that is not what it was.
std::string other_orthos(const std::vector<InputFile>& there, const std::vector<InputFile>& here) {
  if (there.size() != here.size()) return differ("number of --ortho images", there.size(), here.size());
  for (std::size_t i = 0; i < there.size(); ++i) {
    const std::string& path = here[i].path;
    if (const auto names = other_files({there[i]}, {here[i]}); !names.empty())
      return "--ortho " + path + " (" + names + ")";
    if (there[i].bytes != here[i].bytes) {
      return fmt::format("the size of --ortho {}: {} bytes there, {} here", path, there[i].bytes, here[i].bytes);
    }
    if (there[i].modified_s != here[i].modified_s) {
      return fmt::format("--ortho {}, which was modified at {:%F %T} UTC there, at {:%F %T} here", path,
                         fmt::gmtime(there[i].modified_s), fmt::gmtime(here[i].modified_s));
    }
  }
  return {};
}

json files_to_json(const std::vector<InputFile>& files) {
  json out = json::array();
  for (const InputFile& f : files) out.push_back({{"path", f.path}, {"bytes", f.bytes}, {"modified_s", f.modified_s}});
  return out;
}

std::vector<InputFile> files_from_json(const json& j) {
  std::vector<InputFile> out;
  for (const json& f : j.get_ref<const json::array_t&>()) {
    out.push_back(
        {f.at("path").get<std::string>(), f.at("bytes").get<std::uint64_t>(), f.at("modified_s").get<std::int64_t>()});
  }
  return out;
}

bool pictures_are_sane(const Manifest& m) {
  const auto size_ok = [&m](PictureKind kind) {
    const int size = m.picture_size(kind);
    return size == 0 || (size >= 2 && size <= codec::kMaxImageSize);
  };
  const bool depth_ok = m.texture_depth >= 0 && m.texture_depth <= kMostTextureDepth &&
                        m.layout.tile_cells >> m.texture_depth > 0 &&
                        m.picture_layout(PictureKind::kTexture).leaf_level <= codec::kMaxLevel;
  return depth_ok && m.texture_size >= 0 && m.texture_size < codec::kMaxImageSize && size_ok(PictureKind::kTexture) &&
         size_ok(PictureKind::kNormal);
}

/// How files of the same names differ whose heights do.
std::string other_heights(const std::vector<InputFile>& there, const std::vector<InputFile>& here) {
  for (std::size_t i = 0; i < there.size(); ++i) {
    const InputFile& a = there[i];
    const InputFile& b = here[i];
    if (a.bytes != b.bytes) return fmt::format("the size of {}: {} bytes there, {} here", b.path, a.bytes, b.bytes);
    if (a.modified_s != b.modified_s) {
      return fmt::format("the samples of {}, which was modified at {:%F %T} UTC there, at {:%F %T} here", b.path,
                         fmt::gmtime(a.modified_s), fmt::gmtime(b.modified_s));
    }
  }
  return fmt::format("the samples of {}: other heights in files of the same size and time",
                     here.empty() ? "the DEM" : here.front().path);
}

}  // namespace

std::string Manifest::to_json() const {
  json j = {
      {"method", method},
      {"effort", effort},
      {"columns", layout.columns},
      {"rows", layout.rows},
      {"tile_cells", layout.tile_cells},
      {"leaf_level", layout.leaf_level},
      {"dx_m", layout.dx_m},
      {"dy_m", layout.dy_m},
      {"column_axis", layout.axes.column},
      {"row_axis", layout.axes.row},
      {"leaf_error_m", layout.leaf_error_m},
      {"z_step_m", layout.z_step_m},
      {"crs_wkt", crs_wkt},
      {"geotransform", geotransform},
      {"geographic", geographic},
      {"height_unit_m", height_unit_m},
      {"nodata", nodata_name(nodata)},
      {"inputs", files_to_json(inputs)},
      {"samples_digest", samples_digest},
      {"complete", complete},
      {"digest", digest},
  };
  if (texture_size > 0) {
    j["texture_size"] = texture_size;
    if (texture_depth > 0) j["texture_depth"] = texture_depth;
    j["texture_codec"] = texture_codec;
    j["orthos"] = files_to_json(orthos);
  }
  if (normal_maps) j["normal_maps"] = true;
  if (layout.levels_per_doubling != 1) j["levels_per_doubling"] = layout.levels_per_doubling;
  if (!quantizer.empty()) j["quantizer"] = quantizer;
  if (!criterion.empty()) j["criterion"] = criterion;
  return printable(j);
}

Expected<Manifest> Manifest::from_json(const std::string& text) {
  Manifest m;
  try {
    const json j = json::parse(text);
    m.method = j.at("method").get<std::string>();
    m.effort = j.at("effort").get<std::string>();
    if (m.effort != "fast" && m.effort != "best")
      return fail(ErrorCode::kBadData, "the manifest names an unknown --effort");
    if (j.contains("quantizer")) m.quantizer = j.at("quantizer").get<std::string>();
    if (j.contains("criterion")) {
      m.criterion = j.at("criterion").get<std::string>();
      if (m.criterion != "max" && m.criterion != "rms")
        return fail(ErrorCode::kBadData, "the manifest names an unknown --criterion");
    }
    m.layout.columns = j.at("columns").get<std::int64_t>();
    m.layout.rows = j.at("rows").get<std::int64_t>();
    m.layout.tile_cells = j.at("tile_cells").get<int>();
    m.layout.leaf_level = j.at("leaf_level").get<int>();
    if (j.contains("levels_per_doubling")) m.layout.levels_per_doubling = j.at("levels_per_doubling").get<int>();
    m.layout.dx_m = j.at("dx_m").get<double>();
    m.layout.dy_m = j.at("dy_m").get<double>();
    if (j.contains("column_axis") || j.contains("row_axis")) {
      m.layout.axes.column = j.at("column_axis").get<std::array<double, 2>>();
      m.layout.axes.row = j.at("row_axis").get<std::array<double, 2>>();
    }
    m.layout.leaf_error_m = j.at("leaf_error_m").get<double>();
    m.layout.z_step_m = j.at("z_step_m").get<std::vector<double>>();
    m.crs_wkt = j.at("crs_wkt").get<std::string>();
    m.geotransform = j.at("geotransform").get<std::array<double, 6>>();
    m.geographic = j.at("geographic").get<bool>();
    m.height_unit_m = j.at("height_unit_m").get<double>();
    if (j.contains("nodata")) {
      const auto name = j.at("nodata").get<std::string>();
      if (name != kHole && name != kFill) return fail(ErrorCode::kBadData, "the manifest names an unknown --nodata");
      m.nodata = name == kFill ? NodataPolicy::kFill : NodataPolicy::kHole;
    }
    m.inputs = files_from_json(j.at("inputs"));
    if (j.contains("texture_size")) {
      m.texture_size = j.at("texture_size").get<int>();
      m.texture_depth = j.value("texture_depth", 0);
      m.texture_codec = j.at("texture_codec").get<std::string>();
      m.orthos = files_from_json(j.at("orthos"));
    }
    if (j.contains("normal_maps")) m.normal_maps = j.at("normal_maps").get<bool>();
    m.samples_digest = j.at("samples_digest").get<std::string>();
    m.complete = j.at("complete").get<bool>();
    m.digest = j.at("digest").get<std::string>();
  } catch (const json::exception& e) {
    return fail(ErrorCode::kBadData, fmt::format("the manifest cannot be read ({})", e.what()));
  }
  if (!layout_is_sane(m.layout, m.method) || !pictures_are_sane(m))
    return fail(ErrorCode::kBadData, "the manifest describes no possible tree");
  return m;
}

std::string Manifest::difference(const Manifest& other) const {
  const codec::TreeLayout& a = layout;
  const codec::TreeLayout& b = other.layout;
  const bool same_heights = samples_digest == other.samples_digest;
  for (const std::string& d :
       {differ("--method", method, other.method), differ("--effort", effort, other.effort),
        differ("--quantizer", quantizer, other.quantizer), differ("--criterion", criterion, other.criterion),
        differ("--nodata", std::string(nodata_name(nodata)), std::string(nodata_name(other.nodata))),
        differ("--tile", a.tile_cells, b.tile_cells),
        differ("--levels-per-doubling", a.levels_per_doubling, b.levels_per_doubling),
        differ("--normal-maps", normal_maps, other.normal_maps),
        // Says more than the size and spacing that come of it.
        same_heights ? std::string() : other_files(inputs, other.inputs),
        differ("columns of the DEM", a.columns, b.columns), differ("rows of the DEM", a.rows, b.rows),
        differ("sample spacing east-west", a.dx_m, b.dx_m), differ("sample spacing north-south", a.dy_m, b.dy_m),
        differ("--error", a.leaf_error_m, b.leaf_error_m), differ("height unit", height_unit_m, other.height_unit_m)}) {
    if (!d.empty()) return d;
  }
  if (a.axes != b.axes) return "direction of the DEM's rows and columns";
  if (!same_heights) return other_heights(inputs, other.inputs);
  if (crs_wkt != other.crs_wkt || geographic != other.geographic) return "the coordinate reference system of the DEM";
  if (geotransform != other.geotransform) return "the georeference of the DEM";
  if (a.z_step_m != b.z_step_m) return "height steps";
  if (std::string photos = other_orthos(orthos, other.orthos); !photos.empty()) return photos;
  if (std::string size = differ("--texture-size", texture_size, other.texture_size); !size.empty()) return size;
  if (std::string depth = differ("--texture-depth", texture_depth, other.texture_depth); !depth.empty()) return depth;
  return differ("--texture-codec", texture_codec, other.texture_codec);
}

}  // namespace tintree::cache
