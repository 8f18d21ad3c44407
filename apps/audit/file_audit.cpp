#include "apps/audit/file_audit.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "cache/height_blocks.h"
#include "cache/samples_digest.h"

namespace tintree::audit {
namespace {

class FileExamination {
 public:
  explicit FileExamination(const AuditContext& context) : context_(context), store_(context.store) {}

  Expected<std::vector<Violation>> run() {
    if (auto done = compare_keys(); !done) return tl::unexpected(done.error());
    compare_boxes();
    if (auto done = compare_tree_digest(); !done) return tl::unexpected(done.error());
    if (auto done = compare_samples_digest(); !done) return tl::unexpected(done.error());
    return std::move(violations_);
  }

 private:
  void blame(std::optional<codec::TileId> tile, ViolationKind kind, std::string message,
             double severity = kStructural) {
    violations_.push_back({tile, kind, std::move(message), severity});
  }

  /// Rows that the hierarchy does not name; those it names and the table lacks are found tile by tile.
  Expected<void> compare_keys() {
    const auto keys = store_.keys();
    if (!keys) return tl::unexpected(keys.error());
    for (const std::int64_t key : *keys) {
      const codec::TileId id = codec::TileId::from_key(key);
      if (id.key() == key && store_.bounds().find(id) >= 0) continue;
      blame(std::nullopt, ViolationKind::kFile,
            fmt::format("row {} of the table of tiles is none of the hierarchy's tiles", key));
    }
    return {};
  }

  void compare_boxes() {
    const auto nodes = store_.bounds().nodes();
    for (const cache::TileNode& node : nodes) {
      if (node.id.level == 0) continue;
      const codec::TileId above = store_.manifest().layout.parent(node.id);
      const cache::TileNode& parent = nodes[static_cast<std::size_t>(store_.bounds().find(above))];
      if (node.z_min_m >= parent.z_min_m && node.z_max_m <= parent.z_max_m) continue;
      blame(node.id, ViolationKind::kHierarchy,
            fmt::format("its box of {:.9g} to {:.9g} m reaches out of that of its parent, {:.9g} to {:.9g} m",
                        node.z_min_m, node.z_max_m, parent.z_min_m, parent.z_max_m));
    }
  }

  Expected<void> compare_tree_digest() {
    const auto digest = store_.digest();
    // A damaged tile is found and named where tiles are examined.
    if (!digest && digest.error().code == ErrorCode::kBadData) return {};
    if (!digest) return tl::unexpected(digest.error());
    // Whatever tile was changed says more than this.
    compare_digests("tiles", store_.manifest().digest, *digest, kStructural / 2);
    return {};
  }

  Expected<void> compare_samples_digest() {
    const std::shared_ptr<const cache::RasterSource> source(std::shared_ptr<void>(), &context_.source);
    cache::HeightBlocks blocks(source, 0);
    cache::SamplesDigest digest(blocks);
    bool stopped = false;
    const auto streamed = blocks.stream([&](std::int64_t bx, std::int64_t by, const auto& block) {
      digest.add(bx, by, *block);
      stopped = !context_.advance(std::int64_t{cache::kBlockCells} * cache::kBlockCells);
      return !stopped;
    });
    if (!streamed) return streamed;
    if (stopped) return tl::unexpected(stopped_error());
    // Explains whatever else is found.
    compare_digests("heights of the DEM given", store_.manifest().samples_digest, digest.text(), 2 * kStructural);
    return {};
  }

  void compare_digests(const char* what, const std::string& stated, const std::string& found, double severity) {
    if (stated == found) return;
    blame(std::nullopt, ViolationKind::kManifest,
          fmt::format("the digest of the {} is {}, but the manifest states {}", what, found,
                      stated.empty() ? "none" : stated),
          severity);
  }

  const AuditContext& context_;
  const cache::TileStore& store_;
  std::vector<Violation> violations_;
};

}  // namespace

Expected<std::vector<Violation>> audit_file(const AuditContext& context) { return FileExamination(context).run(); }

}  // namespace tintree::audit
