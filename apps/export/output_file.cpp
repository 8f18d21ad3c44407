#include "apps/export/output_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include <unistd.h>

namespace tintree::exporter {

Expected<OutputFile> OutputFile::create(const std::string& path, const std::string& suffix) {
  const std::string temporary = path + suffix;
  std::FILE* file = std::fopen(temporary.c_str(), "w+be");
  if (file == nullptr) return fail(ErrorCode::kIo, std::string("cannot be written: ") + std::strerror(errno), path);
  return OutputFile(path, temporary, file);
}

OutputFile::~OutputFile() {
  if (!file_) return;
  file_.reset();
  std::error_code ec;
  std::filesystem::remove(temporary_, ec);
}

void OutputFile::note_failure() {
  if (failure_ == 0) failure_ = errno != 0 ? errno : EIO;
}

void OutputFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) note_failure();
}

void OutputFile::write_at(std::uint64_t position, std::string_view bytes) {
  if (fseeko(file_.get(), static_cast<off_t>(position), SEEK_SET) != 0) note_failure();
  write(bytes);
  if (fseeko(file_.get(), 0, SEEK_END) != 0) note_failure();
}

void OutputFile::append(OutputFile& other) {
  std::rewind(other.file_.get());
  std::array<char, 1 << 16> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), other.file_.get())) {
    write({buffer.data(), n});
  }
  if (std::ferror(other.file_.get()) != 0) note_failure();
  if (other.failure_ != 0 && failure_ == 0) failure_ = other.failure_;
}

Expected<void> OutputFile::ok() const {
  if (failure_ == 0) return {};
  return fail(ErrorCode::kIo, std::string("cannot be written: ") + std::strerror(failure_), goal_);
}

Expected<void> OutputFile::commit() {
  errno = 0;
  if (std::fflush(file_.get()) != 0 || ::fsync(fileno(file_.get())) != 0) note_failure();
  if (auto done = ok(); !done) return done;
  std::error_code ec;
  std::filesystem::rename(temporary_, goal_, ec);
  if (ec) return fail(ErrorCode::kIo, "cannot be put in place: " + ec.message(), goal_);
  file_.reset();
  return {};
}

}  // namespace tintree::exporter
