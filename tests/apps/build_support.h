#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cache/tile_store.h"
#include "tests/support/run_program.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::test {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

inline constexpr int kDone = 0;
inline constexpr int kUsage = 2;
inline constexpr int kBadData = 3;
inline constexpr int kIo = 4;
inline constexpr int kStopped = 5;

/// Exactly one line, by the program and with the words.
inline void expect_message(const ProgramResult& r, const Words& words) {
  EXPECT_TRUE(r.err.starts_with("tintree-build: ")) << r.err;
  EXPECT_EQ(std::ranges::count(r.err, '\n'), 1) << r.err;
  EXPECT_TRUE(r.err.ends_with('\n'));
  for (const std::string& word : words) EXPECT_NE(r.err.find(word), std::string::npos) << word << " not in: " << r.err;
}

class BuildTest : public testing::Test {
 protected:
  BuildTest() : dem_(dir_.file("dem.tif")), tree_(dir_.file("tree.tintree")), report_(dir_.file("report.json")) {
    write_raster(dem_, {.columns = 90, .rows = 70, .dx = 10, .dy = 10}, [](int c, int r) { return hills(c, r); });
  }

  ProgramResult build(Words more = {}) const { return run_program(TINTREE_BUILD, words(std::move(more))); }

  /// The program's arguments for a quiet build; of small tiles on two threads unless `more` says otherwise.
  Words words(Words more) const {
    const auto add_default = [&more](const std::string& option, const std::string& value) {
      if (std::ranges::find(more, option) == more.end()) more.insert(more.begin(), {option, value});
    };
    add_default("--tile", "32");
    add_default("--threads", "2");
    add_default("-o", tree_);
    more.insert(more.begin(), {dem_, "--quiet"});
    return more;
  }

  /// A build under a shell script that starts it by "$@".
  ProgramResult build_under(const std::string& script, const Words& more = {}) const {
    Words all{"-c", script, "sh", TINTREE_BUILD};
    for (const std::string& word : words(more)) all.push_back(word);
    return run_program("/bin/sh", all);
  }

  void expect_refused(const Words& more, int exit_code, const Words& message) const {
    const ProgramResult r = build(more);
    EXPECT_EQ(r.exit_code, exit_code) << r.all();
    EXPECT_EQ(r.out, "");
    expect_message(r, message);
    EXPECT_FALSE(fs::exists(tree_));
    EXPECT_FALSE(fs::exists(cache::TileWriter::building_path(tree_)));
  }

  /// The digest that a build reports, whose tree is whole.
  std::string digest(const Words& more = {}) const {
    Words all = more;
    all.insert(all.end(), {"--json", report_});
    const ProgramResult r = build(all);
    EXPECT_EQ(r.exit_code, kDone) << r.all();
    if (r.exit_code != kDone) return {};
    const auto store = cache::TileStore::open(tree_);
    EXPECT_TRUE(store.has_value());
    EXPECT_FALSE(fs::exists(cache::TileWriter::building_path(tree_)));
    const std::string found = nlohmann::json::parse(read_file(report_)).at("digest");
    if (store) {
      EXPECT_EQ(store->manifest().digest, found);
    }
    return found;
  }

  TempDir dir_;
  std::string dem_;
  std::string tree_;
  std::string report_;
};

}  // namespace tintree::test
