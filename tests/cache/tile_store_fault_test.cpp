// What the store does when the file is damaged, the disk is full or the process dies.

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <sched.h>
#include <sqlite3.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cache/tile_store.h"
#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::cache {
namespace {

namespace fs = std::filesystem;
using test::TestTree;

const TestTree& small_tree() {
  static const TestTree tree = [] {
    const test::TempDir dir;
    test::write_raster(dir.file("dem.tif"), {.columns = 40, .rows = 30},
                       [](int c, int r) { return test::hills(c, r); });
    return test::make_regular_tree(dir.file("dem.tif"));
  }();
  return tree;
}

/// Writes the tree like write_tree(), but hands back the failure.
Expected<std::string> build(const std::string& path, const TestTree& tree) {
  auto writer = TileWriter::create(path, tree.manifest);
  if (!writer) return tl::unexpected(writer.error());
  for (const StoredTile& tile : tree.tiles) {
    if (auto done = writer->put(tile); !done) return tl::unexpected(done.error());
    if (auto done = writer->commit(); !done) return tl::unexpected(done.error());
  }
  return writer->finish();
}

/// Goes on with an unfinished tree and finishes it.
Expected<std::string> go_on(const std::string& path, const TestTree& tree) {
  auto writer = TileWriter::resume(path, tree.manifest);
  if (!writer) return tl::unexpected(writer.error());
  const auto keys = writer->keys();
  if (!keys) return tl::unexpected(keys.error());
  for (const StoredTile& tile : tree.tiles) {
    if (std::ranges::binary_search(*keys, tile.info.id.key())) continue;
    if (auto done = writer->put(tile); !done) return tl::unexpected(done.error());
  }
  return writer->finish();
}

class DamageTest : public testing::Test {
 protected:
  DamageTest() {
    test::write_tree(path_, small_tree());
    bytes_ = test::read_file(path_);
    const auto store = TileStore::open(path_);
    if (!store) throw std::runtime_error(store.error().text());
    manifest_ = store->manifest().to_json();
    bounds_ = store->bounds().to_bytes();
  }

  /// True when the damage is reported somewhere; fails the test when something differs in silence.
  bool reported(const std::string& what) {
    SCOPED_TRACE(what);
    const bool found = look();
    for (const char* suffix : {"-wal", "-shm", "-journal"}) fs::remove(path_ + suffix);
    return found;
  }

  const std::string& bytes() const { return bytes_; }
  const std::string& path() const { return path_; }

 private:
  bool look() const {
    const auto store = TileStore::open(path_);
    if (!store) {
      expect_clear(store.error());
      return true;
    }
    EXPECT_EQ(store->manifest().to_json(), manifest_);
    EXPECT_EQ(store->bounds().to_bytes(), bounds_);
    bool found = false;
    for (const StoredTile& expected : small_tree().tiles) {
      const auto tile = store->read(expected.info.id);
      if (!tile) {
        expect_clear(tile.error());
        found = true;
        continue;
      }
      EXPECT_EQ(tile->payload, expected.payload);
      EXPECT_EQ(tile->info.error_m, expected.info.error_m);
      EXPECT_EQ(tile->info.border_error_m, expected.info.border_error_m);
      EXPECT_EQ(tile->info.vertices, expected.info.vertices);
    }
    return found;
  }

  void expect_clear(const Error& error) const {
    EXPECT_EQ(error.code, ErrorCode::kBadData) << error.text();
    EXPECT_NE(error.text().find(path_), std::string::npos) << error.text();
  }

  test::TempDir dir_;
  std::string path_ = dir_.file("t.tintree");
  std::string bytes_;
  std::string manifest_;
  std::vector<std::byte> bounds_;
};

TEST_F(DamageTest, FlippedBytesNeverChangeContentInSilence) {
  std::mt19937 random(1);
  std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
  const auto poke = [&file](std::size_t at, char value) {
    file.seekp(static_cast<std::streamoff>(at));
    file.put(value);
    file.flush();
  };
  const auto flip_at = [&](std::size_t at) {
    const char damage = static_cast<char>(bytes()[at] ^ static_cast<char>(1 + random() % 255));
    poke(at, damage);
    const bool found = reported("byte " + std::to_string(at) + " is " + std::to_string(damage));
    poke(at, bytes()[at]);
    return found;
  };
  int found = 0;
  // The header, the schema's page and the places where something is written, which are a part of the file.
  for (std::size_t at = 0; at < 140 && !HasFailure(); ++at) found += flip_at(at);
  std::vector<std::size_t> written;
  for (std::size_t at = 140; at < bytes().size(); ++at) {
    if (bytes()[at] != 0) written.push_back(at);
  }
  for (int i = 0; i < 3000 && !HasFailure(); ++i) found += flip_at(written[random() % written.size()]);
  for (int i = 0; i < 500 && !HasFailure(); ++i) found += flip_at(random() % bytes().size());
  EXPECT_GT(found, 2000);
  EXPECT_FALSE(reported("repaired"));
}

TEST_F(DamageTest, EveryTruncationIsReported) {
  std::mt19937 random(2);
  std::vector<std::size_t> sizes = {0, 1, 15, 16, 99, 100, 101, bytes().size() - 1};
  for (std::size_t s = 4096; s < bytes().size(); s += 4096) sizes.push_back(s);
  for (int i = 0; i < 100; ++i) sizes.push_back(random() % bytes().size());
  for (const std::size_t size : sizes) {
    test::write_file(path(), bytes().substr(0, size));
    EXPECT_TRUE(reported("cut to " + std::to_string(size)));
  }
}

TEST_F(DamageTest, ZeroedAndSwappedPagesAreReported) {
  const auto header = [this](std::size_t at) {
    return static_cast<std::size_t>(static_cast<std::uint8_t>(bytes()[at]));
  };
  const std::size_t page_bytes = 256 * header(16) + header(17);
  ASSERT_GE(page_bytes, 512U);
  const std::size_t pages = bytes().size() / page_bytes;
  for (std::size_t p = 0; p < pages; ++p) {
    std::string damaged = bytes();
    damaged.replace(p * page_bytes, page_bytes, page_bytes, '\0');
    test::write_file(path(), damaged);
    EXPECT_TRUE(reported("zeroed page " + std::to_string(p)));
    for (std::size_t q = p + 1; q < pages; ++q) {
      damaged = bytes();
      damaged.replace(p * page_bytes, page_bytes, bytes(), q * page_bytes, page_bytes);
      damaged.replace(q * page_bytes, page_bytes, bytes(), p * page_bytes, page_bytes);
      test::write_file(path(), damaged);
      EXPECT_TRUE(reported("swapped pages " + std::to_string(p) + " and " + std::to_string(q)));
    }
  }
}

TEST_F(DamageTest, FilesWithoutTheirTablesAreReported) {
  for (const char* sql : {"DROP TABLE tile", "DROP TABLE metadata", "DELETE FROM metadata WHERE name = 'manifest'",
                          "DELETE FROM metadata WHERE name = 'bounds'", "DELETE FROM tile WHERE key = 0",
                          "ALTER TABLE tile RENAME COLUMN error_m TO e",
                          "UPDATE tile SET payload = NULL WHERE 0; UPDATE tile SET payload = x''",
                          "UPDATE tile SET error_m = error_m + 1", "UPDATE tile SET vertices = vertices + 1",
                          "UPDATE tile SET key = key + 1000", "UPDATE metadata SET value = x'7b7d'"}) {
    test::write_file(path(), bytes());
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path().c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
    EXPECT_TRUE(reported(sql));
  }
}

// SQLite's own door for tests: its system calls can be replaced one by one.
int g_writes_left = -1;  // < 0: no limit
int g_write_error = ENOSPC;

ssize_t full_pwrite(int fd, const void* data, size_t size, off_t at) {
  if (g_writes_left == 0) {
    errno = g_write_error;
    return -1;
  }
  if (g_writes_left > 0) --g_writes_left;
  return ::pwrite(fd, data, size, at);
}

/// While it lives SQLite may write `writes` times, then each write fails: with ENOSPC the disk is full.
class FullDisk {
 public:
  explicit FullDisk(int writes, int error = ENOSPC) {
    g_writes_left = writes;
    g_write_error = error;
    replace(reinterpret_cast<sqlite3_syscall_ptr>(&full_pwrite));
  }
  ~FullDisk() {
    g_writes_left = -1;
    replace(nullptr);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  bool filled() const { return g_writes_left == 0; }

 private:
  static void replace(sqlite3_syscall_ptr call) {
    sqlite3_vfs* vfs = sqlite3_vfs_find(nullptr);
    bool any = false;
    for (const char* name : {"pwrite", "pwrite64"}) any = vfs->xSetSystemCall(vfs, name, call) == SQLITE_OK || any;
    if (!any) throw std::runtime_error("SQLite's writes cannot be replaced");
  }
};

TEST(FullDiskTest, WhereverItFillsUpNothingLooksWholeAndTheBuildCanGoOn) {
  const test::TempDir dir;
  const std::string whole = build(dir.file("whole.tintree"), small_tree()).value();
  const std::string path = dir.file("t.tintree");
  int writes = 0;
  for (bool full = true; full; writes += writes < 40 ? 1 : 7) {
    ASSERT_LT(writes, 2000);
    SCOPED_TRACE(std::to_string(writes) + " writes");
    std::string digest;
    {
      const FullDisk disk(writes);
      const auto built = build(path, small_tree());
      full = disk.filled() && !built.has_value();
      if (built) {
        digest = *built;
      } else {
        EXPECT_EQ(built.error().code, ErrorCode::kIo);
        EXPECT_NE(built.error().message.find("disk is full"), std::string::npos) << built.error().text();
        EXPECT_FALSE(fs::exists(path));
      }
    }
    if (!full) {
      EXPECT_EQ(digest, whole);
      continue;
    }
    // Whatever has the name of an unfinished build can be resumed.
    if (fs::exists(TileWriter::building_path(path))) {
      const auto finished = go_on(path, small_tree());
      ASSERT_TRUE(finished.has_value()) << finished.error().text();
      EXPECT_EQ(*finished, whole);
      EXPECT_TRUE(TileStore::open(path).has_value());
      EXPECT_EQ(std::distance(fs::directory_iterator(dir.path()), {}), 2) << "something is left over";
    } else {
      EXPECT_LT(writes, 30);
    }
    for (const auto& entry : fs::directory_iterator(dir.path())) {
      if (entry.path().filename().string().starts_with("t.tintree")) fs::remove(entry.path());
    }
  }
  EXPECT_GT(writes, 20) << "the disk never filled up";
}

TEST(FailedWriteTest, SaysWhatTheSystemSaysAndTheBuildCanGoOn) {
  const test::TempDir dir;
  const std::string whole = build(dir.file("whole.tintree"), small_tree()).value();
  const std::string path = dir.file("t.tintree");
  for (const int writes : {15, 25, 40}) {
    SCOPED_TRACE(writes);
    {
      const FullDisk disk(writes, EIO);
      const auto built = build(path, small_tree());
      ASSERT_FALSE(built.has_value());
      EXPECT_EQ(built.error().code, ErrorCode::kIo);
      EXPECT_NE(built.error().text().find(path), std::string::npos) << built.error().text();
      EXPECT_NE(built.error().text().find("cannot be read or written"), std::string::npos) << built.error().text();
    }
    EXPECT_FALSE(fs::exists(path));
    if (!fs::exists(TileWriter::building_path(path))) continue;
    EXPECT_EQ(go_on(path, small_tree()).value(), whole);
    fs::remove(path);
  }
}

/// Runs `body` in a child process and gives its exit code; 128 + signal when one killed it.
int in_child(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    int code = 99;
    try {
      code = body();
    } catch (...) {
    }
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// 0: the failure is as it should be; 1: not.
int judge_failed_build(const std::string& path) {
  // A tree that is larger than the disk: every tile with a payload of 100 kB.
  TestTree tree = small_tree();
  for (StoredTile& tile : tree.tiles) tile.payload.resize(100000);
  const auto built = build(path, tree);
  const bool told =
      !built && built.error().code == ErrorCode::kIo && built.error().text().find(path) != std::string::npos;
  if (!told) std::fprintf(stderr, "%s\n", built ? "was built" : built.error().text().c_str());
  return told && !fs::exists(path) ? 0 : 1;
}

TEST(FullDiskTest, ARealFullFileSystem) {
  const test::TempDir dir;
  constexpr int kNoMount = 77;
  const int code = in_child([&dir] {
    // A mount namespace of its own: nothing of this is seen outside.
    if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return kNoMount;
    if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return kNoMount;
    if (mount("tmpfs", dir.path().c_str(), "tmpfs", 0, "size=400k") != 0) return kNoMount;
    return judge_failed_build(dir.file("t.tintree"));
  });
  if (code == kNoMount) GTEST_SKIP() << "no small file system can be mounted here";
  EXPECT_EQ(code, 0);
}

TEST(FullDiskTest, AFileSizeLimit) {
  const test::TempDir dir;
  const int code = in_child([&dir] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{300000, 300000};
    setrlimit(RLIMIT_FSIZE, &limit);
    return judge_failed_build(dir.file("t.tintree"));
  });
  EXPECT_EQ(code, 0);
}

TEST(PermissionTest, AFolderThatMayNotBeWrittenTo) {
  const test::TempDir dir;
  const auto owner = fs::perms::owner_read | fs::perms::owner_exec;
  fs::permissions(dir.path(), owner | fs::perms::others_read | fs::perms::others_exec);
  const int code = in_child([&dir] {
    constexpr uid_t kNobody = 65534;
    if (geteuid() == 0 && setuid(kNobody) != 0) return 2;
    const std::string path = dir.file("t.tintree");
    const auto writer = TileWriter::create(path, small_tree().manifest);
    if (writer || writer.error().code != ErrorCode::kIo) return 1;
    return writer.error().text().find(path) != std::string::npos ? 0 : 1;
  });
  EXPECT_EQ(code, 0);
}

TEST(KillTest, ABuildSurvivesSigkillAndGoesOn) {
  const test::TempDir dir;
  const std::string whole = build(dir.file("whole.tintree"), small_tree()).value();
  const std::size_t count = small_tree().tiles.size();
  for (std::size_t put = 0; put <= count; ++put) {
    SCOPED_TRACE(std::to_string(put) + " tiles");
    const std::string path = dir.file("t" + std::to_string(put) + ".tintree");
    const std::size_t committed = put / 2;
    const int code = in_child([&] {
      auto writer = TileWriter::create(path, small_tree().manifest);
      for (std::size_t i = 0; i < put; ++i) {
        if (i == committed && !writer->commit()) return 1;
        if (!writer->put(small_tree().tiles[i])) return 1;
      }
      return raise(SIGKILL);
    });
    ASSERT_EQ(code, 128 + SIGKILL);
    EXPECT_FALSE(fs::exists(path));
    {
      const auto writer = TileWriter::resume(path, small_tree().manifest);
      ASSERT_TRUE(writer.has_value()) << writer.error().text();
      EXPECT_GE(writer->keys()->size(), put > 0 ? committed : 0);
    }
    const auto finished = go_on(path, small_tree());
    ASSERT_TRUE(finished.has_value()) << finished.error().text();
    EXPECT_EQ(*finished, whole);
  }
}

}  // namespace
}  // namespace tintree::cache
