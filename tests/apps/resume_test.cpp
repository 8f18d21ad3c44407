/// A build that is stopped, killed or fails loses no work: it can be gone on with, and ends in the same tree.

#include <chrono>
#include <csignal>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>

#include <sqlite3.h>
#include <sys/stat.h>

#include "tests/apps/build_support.h"

namespace tintree::test {
namespace {

using nlohmann::json;
using std::chrono::duration;
using Keys = std::set<std::int64_t>;

void sleep_for(double seconds) { std::this_thread::sleep_for(duration<double>(seconds)); }

class ResumeTest : public BuildTest {
 protected:
  ResumeTest() : building_(cache::TileWriter::building_path(tree_)) {}

  /// Several levels of rough tiles, so that a build takes a while.
  void write_large_dem(int columns = 240, int rows = 200) const {
    write_raster(dem_, {.columns = columns, .rows = rows},
                 [](int c, int r) { return hills(c, r, 60) + (c * 7 + r * 13) % 5; });
  }

  std::unique_ptr<RunningProgram> start(const Words& more = {}) const {
    return std::make_unique<RunningProgram>(TINTREE_BUILD, words(more));
  }

  /// Waits until a file is there, or the program has ended.
  static void wait_for_file(RunningProgram& program, const std::string& path) {
    while (program.running() && !fs::exists(path)) sleep_for(0.0005);
  }

  /// Keys of the tiles that a killed build left, read from a copy so that the original stays as it was left.
  Keys keys_left() const {
    Keys keys;
    if (!fs::exists(building_)) return keys;
    const TempDir copies;
    const std::string copy = copies.file("copy");
    for (const char* suffix : {"", "-wal"}) {
      if (fs::exists(building_ + suffix)) fs::copy_file(building_ + suffix, copy + suffix);
    }
    sqlite3* db = nullptr;
    const auto collect = [](void* out, int, char** values, char**) {
      static_cast<Keys*>(out)->insert(std::stoll(values[0]));
      return 0;
    };
    const bool read = sqlite3_open(copy.c_str(), &db) == SQLITE_OK &&
                      sqlite3_exec(db, "SELECT key FROM tile", collect, &keys, nullptr) == SQLITE_OK;
    EXPECT_TRUE(read) << sqlite3_errmsg(db);
    sqlite3_close(db);
    return keys;
  }

  /// Finishes by --resume: the digest. Checks that no tile was made that was there.
  std::string finish(const Words& more = {}) const {
    const Keys before = keys_left();
    const bool finished = !fs::exists(building_) && fs::exists(tree_);
    Words all = more;
    all.emplace_back("--resume");
    const std::string found = digest(all);
    if (found.empty()) return found;
    const json report = json::parse(read_file(report_));
    const std::uint64_t tiles = report.at("tiles");
    EXPECT_EQ(report.at("tiles_made"), finished ? 0 : tiles - before.size());
    EXPECT_EQ(std::distance(fs::directory_iterator(dir_.path()), {}), 3) << "only DEM, tree and report are left";
    return found;
  }

  void clear() const {
    for (const auto& entry : fs::directory_iterator(dir_.path())) {
      if (entry.path() != dem_) fs::remove(entry.path());
    }
  }

  std::string building_;
};

TEST_F(ResumeTest, SurvivesKillsAtAnyMoment) {
  write_large_dem();
  const auto begun = std::chrono::steady_clock::now();
  const std::string whole = digest();
  const double seconds = duration<double>(std::chrono::steady_clock::now() - begun).count();
  clear();

  std::mt19937 random(7);
  std::uniform_real_distribution<> share(0, 0.4);
  // Besides random moments those that are too short to be met by chance: the file's beginning, and its end.
  const std::vector<std::string> marks = {building_ + "-new", building_, building_ + "-packed", tree_};
  constexpr int kKills = 20;
  Keys before;
  for (int kill = 0; kill < kKills; ++kill) {
    SCOPED_TRACE("kill " + std::to_string(kill));
    const auto program = start({"--resume"});
    if (kill % 5 == 4) {
      wait_for_file(*program, marks[static_cast<std::size_t>(kill / 5)]);
    } else {
      sleep_for(share(random) * seconds);
    }
    program->send(SIGKILL);
    const ProgramResult r = program->wait();
    ASSERT_TRUE(r.exit_code == kDone || r.exit_code == 128 + SIGKILL) << r.all();
    Keys after = keys_left();
    if (fs::exists(building_)) {
      EXPECT_TRUE(std::ranges::includes(after, before)) << "tiles are lost";
    }
    // Now and then to the end, else on from kill to kill.
    if (!fs::exists(building_) && fs::exists(tree_)) {
      EXPECT_EQ(finish(), whole);
      clear();
      after.clear();
    }
    before = std::move(after);
  }
  EXPECT_EQ(finish(), whole);
}

TEST_F(ResumeTest, StopsAtAnyMoment) {
  write_large_dem();
  const std::string whole = digest();
  clear();
  const std::vector<std::string> marks = {building_ + "-new", building_, building_ + "-packed"};
  for (const std::string& mark : marks) {
    for (const int signal : {SIGINT, SIGTERM}) {
      SCOPED_TRACE(mark);
      const auto program = start();
      wait_for_file(*program, mark);
      program->send(signal);
      const ProgramResult r = program->wait();
      // The first and the last moments may be over before they are seen, or the signal comes.
      if (r.exit_code == kDone && mark != building_) {
        clear();
        continue;
      }
      EXPECT_EQ(r.exit_code, kStopped) << r.all();
      expect_message(r, {tree_, "stopped", "--resume"});
      EXPECT_FALSE(fs::exists(tree_));
      EXPECT_FALSE(fs::exists(building_ + "-packed"));
      EXPECT_EQ(finish(), whole);
      clear();
    }
  }
}

TEST_F(ResumeTest, StopsInsideATile) {
  // One tile, which takes seconds.
  write_large_dem(1000, 1000);
  const Words one_tile = {"--tile", "1024", "--error", "1"};
  const auto program = start(one_tile);
  wait_for_file(*program, building_);
  sleep_for(0.1);
  program->send(SIGINT);
  const ProgramResult r = program->wait();
  EXPECT_EQ(r.exit_code, kStopped) << r.all();
  expect_message(r, {tree_, "--resume"});
  EXPECT_TRUE(fs::exists(building_));
  EXPECT_TRUE(keys_left().empty()) << "it waited for the tile";
}

TEST_F(ResumeTest, StopsWhereItHangs) {
  // The DEM comes from a pipe that says nothing: no flag is looked at while GDAL waits for it.
  const std::string pipe = dir_.file("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  RunningProgram program("/bin/sh", {"-c", R"(exec 3<>"$0" && exec "$@" <"$0")", pipe, TINTREE_BUILD, "/vsistdin/",
                                     "-o", tree_, "--quiet"});
  // Not SIGINT, which the shell catches too.
  while (program.running() && !program.handles(SIGTERM)) sleep_for(0.001);
  program.send(SIGINT);
  const ProgramResult r = program.wait();
  EXPECT_EQ(r.exit_code, kStopped) << r.all();
  expect_message(r, {tree_, "--resume"});
}

TEST_F(ResumeTest, AStoppedOverwritingBuildKeepsTheOldTreeUntilItIsResumed) {
  write_large_dem();
  write_file(tree_, "precious");
  const auto program = start({"--overwrite"});
  wait_for_file(*program, building_);
  program->send(SIGINT);
  const ProgramResult r = program->wait();
  EXPECT_EQ(r.exit_code, kStopped) << r.all();
  expect_message(r, {tree_, "--resume instead of --overwrite"});
  EXPECT_EQ(read_file(tree_), "precious");
  const ProgramResult again = build();
  EXPECT_EQ(again.exit_code, kIo) << "work is not thrown away in silence";
  expect_message(again, {building_, "--resume"});
  EXPECT_NE(finish(), "");
}

TEST_F(ResumeTest, BeginsWhereThereIsNothingAndEndsWhereAllIsDone) {
  const std::string first = digest({"--resume"});
  EXPECT_EQ(first.size(), 32U);
  const std::string bytes = read_file(tree_);
  EXPECT_EQ(digest({"--resume"}), first);
  const json report = json::parse(read_file(report_));
  EXPECT_EQ(report.at("tiles_made"), 0);
  EXPECT_GT(report.at("tiles"), 0);
  EXPECT_GT(report.at("levels")[0].at("vertical_max_m"), 0);
  EXPECT_EQ(read_file(tree_), bytes) << "the finished tree is left alone";
  const ProgramResult other = build({"--resume", "--error", "3"});
  EXPECT_EQ(other.exit_code, kUsage) << other.all();
  expect_message(other, {tree_, "--error"});
}

/// A build stopped after some tiles.
class StoppedTest : public ResumeTest {
 protected:
  StoppedTest() {
    write_large_dem();
    const auto program = start();
    wait_for_file(*program, building_);
    program->send(SIGINT);
    if (program->wait().exit_code != kStopped) throw std::runtime_error("the build was not stopped");
  }

  void expect_resume_refused(const Words& more, const Words& message) const {
    Words all = more;
    all.emplace_back("--resume");
    const ProgramResult r = build(all);
    EXPECT_EQ(r.exit_code, kUsage) << r.all();
    expect_message(r, message);
    EXPECT_TRUE(fs::exists(building_));
  }
};

TEST_F(StoppedTest, RefusesOtherOptionsByName) {
  expect_resume_refused({"--error", "3"}, {building_, "--error", "0.5 there, 3 here"});
  expect_resume_refused({"--tile", "64"}, {building_, "--tile", "32 there, 64 here"});
  expect_resume_refused({"--levels-per-doubling", "2"}, {building_, "--levels-per-doubling", "1 there, 2 here"});
  expect_resume_refused({"--effort", "best"}, {building_, "--effort", "fast there, best here"});
  EXPECT_NE(finish({"--threads", "1", "--memory", "900"}), "") << "these change no tile";
}

TEST_F(StoppedTest, RefusesAnotherInputByName) {
  const std::string bytes = read_file(dem_);
  const auto time = fs::last_write_time(dem_);
  write_large_dem(241, 200);
  expect_resume_refused({}, {"columns", "240 there, 241 here"});

  // One sample differs, in a file of the same size and time.
  std::string changed = bytes;
  changed[changed.size() - 2] = static_cast<char>(changed[changed.size() - 2] ^ 0x10);
  write_file(dem_, changed);
  fs::last_write_time(dem_, time);
  expect_resume_refused({}, {dem_, "same size and time"});
  fs::last_write_time(dem_, time + std::chrono::hours(1));
  expect_resume_refused({}, {dem_, "modified"});
  write_file(dem_, changed + "more");
  expect_resume_refused({}, {dem_, "bytes there"});

  // The same samples in a file that was copied are the same input.
  write_file(dem_, bytes);
  EXPECT_NE(finish(), "");
}

TEST_F(StoppedTest, RefusesAMissingInputAndGoesOnWhenItIsBack) {
  fs::rename(dem_, dem_ + ".away");
  const ProgramResult r = build({"--resume"});
  EXPECT_EQ(r.exit_code, kIo) << r.all();
  expect_message(r, {dem_, "no such file"});
  fs::rename(dem_ + ".away", dem_);
  EXPECT_NE(finish(), "");
}

TEST_F(StoppedTest, LetsNoSecondBuildIn) {
  const auto first = start({"--resume"});
  // SQLite's lock is taken with the first look into the file.
  wait_for_file(*first, building_ + "-wal");
  for (const char* option : {"--resume", "--overwrite"}) {
    const ProgramResult second = build({option});
    if (!first->running()) GTEST_SKIP() << "the first build was over before the second began";
    EXPECT_EQ(second.exit_code, kIo) << second.all();
    expect_message(second, {building_, "another program"});
  }
  EXPECT_EQ(first->wait().exit_code, kDone);
}

TEST_F(ResumeTest, ADirectoryInTheWayOfTheBuild) {
  fs::create_directory(building_);
  for (const Words& more : {Words{}, Words{"--resume"}, Words{"--overwrite"}}) {
    const ProgramResult r = build(more);
    EXPECT_EQ(r.exit_code, kIo) << r.all();
    expect_message(r, {building_, "directory"});
  }
}

TEST_F(ResumeTest, GoesOnOnceTheDiskHasRoom) {
  write_large_dem();
  const std::string whole = digest();
  const std::uint64_t blocks = fs::file_size(tree_) / 512;
  clear();
  int failures = 0;
  // No file may grow beyond so many blocks of 512 bytes.
  for (const std::uint64_t limit : {blocks / 2, blocks * 9 / 10}) {
    SCOPED_TRACE(limit);
    const ProgramResult r = build_under("ulimit -f " + std::to_string(limit) + "; exec \"$@\"", {"--resume"});
    EXPECT_EQ(r.exit_code, kIo) << r.all();
    expect_message(r, {tree_, "--resume"});
    EXPECT_FALSE(fs::exists(tree_));
    EXPECT_FALSE(fs::exists(building_ + "-packed")) << "takes room and serves nobody";
    ++failures;
  }
  EXPECT_EQ(failures, 2);
  EXPECT_EQ(finish(), whole);
}

TEST_F(ResumeTest, GoesOnOnceAFullFileSystemHasRoom) {
  write_large_dem();
  const std::string whole = digest();
  clear();
  // A mount namespace of its own: nothing of this is seen outside.
  const std::string script =
      R"(mount -t tmpfs -o size=250k none "$0" || exit 77; d=$0; exec 3<"$1"; shift
         "$@" -o "$d/t"; code=$?; ls "$d" >&2
         mount -o remount,size=50m "$d" && "$@" -o "$d/t" --resume || exit 1; exit $code)";
  const std::string mount = dir_.file("mount");
  fs::create_directory(mount);
  const ProgramResult r =
      run_program("/usr/bin/unshare", {"-m", "/bin/sh", "-c", script, mount, dem_, TINTREE_BUILD, dem_, "--quiet",
                                       "--tile", "32", "--threads", "2", "--json", report_});
  if (r.exit_code == 77 || r.exit_code == 127 || r.err.find("unshare") != std::string::npos) {
    GTEST_SKIP() << "no small file system can be mounted here: " << r.err;
  }
  EXPECT_EQ(r.exit_code, kIo) << r.all();
  EXPECT_NE(r.err.find("the disk is full"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("t.building\n"), std::string::npos) << "nothing was kept: " << r.err;
  EXPECT_EQ(json::parse(read_file(report_)).at("digest"), whole);
}

}  // namespace
}  // namespace tintree::test
