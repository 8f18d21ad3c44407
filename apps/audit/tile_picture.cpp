#include "apps/audit/tile_picture.h"

#include <utility>

#include "apps/audit/shaded_relief.h"

namespace tintree::audit {

Expected<TilePictures> draw_tile(const AuditContext& context, const TileFigures& tile, int longest_px) {
  const codec::TreeLayout& layout = context.store.manifest().layout;
  const codec::CellRect cells = layout.cells(tile.id);
  const auto dem = picture_of_dem(context.source, cells, longest_px);
  if (!dem) return tl::unexpected(dem.error());
  const double gain = relief_gain(*dem, layout);
  TilePictures pictures;
  pictures.width_px = dem->width_px;
  pictures.height_px = dem->height_px;
  pictures.peak_x_px = (tile.peak.column - static_cast<double>(cells.column0)) /
                       static_cast<double>(cells.column1 - cells.column0) * (dem->width_px - 1);
  pictures.peak_y_px = (tile.peak.row - static_cast<double>(cells.row0)) /
                       static_cast<double>(cells.row1 - cells.row0) * (dem->height_px - 1);
  auto coded = app::png_data_uri(shade(*dem, layout, gain));
  if (!coded) return tl::unexpected(coded.error());
  pictures.dem = std::move(*coded);

  ErrorMap map(cells, longest_px);
  if (auto measured = audit_tile(context, tile.id, &map); !measured) return tl::unexpected(measured.error());
  coded = app::png_data_uri(draw_map(map, tile.bound_m));
  if (!coded) return tl::unexpected(coded.error());
  pictures.errors = std::move(*coded);

  auto mesh = context.store.read_mesh(tile.id);
  if (!mesh) return pictures;
  coded = app::png_data_uri(shade(picture_of_mesh(place(layout, tile.id, std::move(*mesh)), longest_px), layout, gain));
  if (!coded) return tl::unexpected(coded.error());
  pictures.mesh = std::move(*coded);
  return pictures;
}

}  // namespace tintree::audit
