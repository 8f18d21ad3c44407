#include "codec/jpeg2000_plane.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include <openjpeg.h>

namespace tintree::codec {
namespace {

constexpr int kMostResolutions = 6;
constexpr int kLeastSide = 8;  // of the coarsest sub-band, about

struct CodecCloser {
  void operator()(opj_codec_t* codec) const { opj_destroy_codec(codec); }
};
struct ImageCloser {
  void operator()(opj_image_t* image) const { opj_image_destroy(image); }
};
struct StreamCloser {
  void operator()(opj_stream_t* stream) const { opj_stream_destroy(stream); }
};
using Codec = std::unique_ptr<opj_codec_t, CodecCloser>;
using Image = std::unique_ptr<opj_image_t, ImageCloser>;
using Stream = std::unique_ptr<opj_stream_t, StreamCloser>;

int resolutions(int width, int height) {
  int count = 1;
  while (count < kMostResolutions && (std::min(width, height) >> count) >= kLeastSide) ++count;
  return count;
}

void put_number(std::vector<std::byte>& out, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xff));
}

/// SOC, SIZ, COD and QCD (ISO/IEC 15444-1, annex A) of a stream of ours.
std::vector<std::byte> main_header(int width, int height, int bits) {
  std::vector<std::byte> out;
  const int levels = resolutions(width, height) - 1;
  put_number(out, 0xff4f, 2);
  put_number(out, 0xff51, 2);
  put_number(out, 41, 2);
  put_number(out, 0, 2);
  for (int i = 0; i < 2; ++i) {  // the image, then its one tile
    put_number(out, static_cast<std::uint64_t>(width), 4);
    put_number(out, static_cast<std::uint64_t>(height), 4);
    put_number(out, 0, 8);
  }
  put_number(out, 1, 2);
  put_number(out, static_cast<std::uint64_t>(bits - 1), 1);
  put_number(out, 0x0101, 2);
  put_number(out, 0xff52, 2);
  put_number(out, 12, 2);
  put_number(out, 0, 2);  // no precincts; layer, resolution, component, position
  put_number(out, 1, 2);
  put_number(out, 0, 1);
  put_number(out, static_cast<std::uint64_t>(levels), 1);
  put_number(out, 0x0404, 2);  // code blocks of 64 x 64
  put_number(out, 0x0001, 2);  // the 5/3 wavelet
  put_number(out, 0xff5c, 2);
  put_number(out, static_cast<std::uint64_t>(4 + 3 * levels), 2);
  put_number(out, 0x40, 1);  // two guard bits, no quantisation
  put_number(out, static_cast<std::uint64_t>(bits << 3), 1);
  for (int level = 0; level < levels; ++level) {
    put_number(out, static_cast<std::uint64_t>((bits + 1) << 3), 1);
    put_number(out, static_cast<std::uint64_t>((bits + 1) << 3), 1);
    put_number(out, static_cast<std::uint64_t>((bits + 2) << 3), 1);
  }
  return out;
}

/// SOT and SOD of the one tile part.
void put_tile_header(std::vector<std::byte>& out, std::size_t body_bytes) {
  put_number(out, 0xff90, 2);
  put_number(out, 10, 2);
  put_number(out, 0, 2);
  put_number(out, 14 + body_bytes, 4);
  put_number(out, 0x0001, 2);
  put_number(out, 0xff93, 2);
}

constexpr std::size_t kTileHeader = 14;
constexpr std::size_t kEnd = 2;
constexpr std::uint32_t kEndMarker = 0xffd9;

struct Memory {
  std::vector<std::byte> bytes;
  std::size_t at = 0;
};

OPJ_SIZE_T read_memory(void* buffer, OPJ_SIZE_T bytes, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  const std::size_t count = std::min<std::size_t>(bytes, memory.bytes.size() - memory.at);
  if (count == 0) return static_cast<OPJ_SIZE_T>(-1);
  std::memcpy(buffer, memory.bytes.data() + memory.at, count);
  memory.at += count;
  return count;
}

OPJ_SIZE_T write_memory(void* buffer, OPJ_SIZE_T bytes, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  memory.bytes.resize(std::max(memory.bytes.size(), memory.at + bytes));
  std::memcpy(memory.bytes.data() + memory.at, buffer, bytes);
  memory.at += bytes;
  return bytes;
}

OPJ_BOOL seek_memory(OPJ_OFF_T to, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  if (to < 0 || static_cast<std::size_t>(to) > memory.bytes.size()) return OPJ_FALSE;
  memory.at = static_cast<std::size_t>(to);
  return OPJ_TRUE;
}

OPJ_OFF_T skip_memory(OPJ_OFF_T by, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  const auto room = static_cast<OPJ_OFF_T>(memory.bytes.size() - memory.at);
  if (by < 0 || by > room) return -1;
  memory.at += static_cast<std::size_t>(by);
  return by;
}

Stream open_stream(Memory& memory, bool reads) {
  Stream stream(opj_stream_default_create(reads ? OPJ_TRUE : OPJ_FALSE));
  if (!stream) return stream;
  opj_stream_set_user_data(stream.get(), &memory, nullptr);
  opj_stream_set_user_data_length(stream.get(), memory.bytes.size());
  opj_stream_set_read_function(stream.get(), read_memory);
  opj_stream_set_write_function(stream.get(), write_memory);
  opj_stream_set_seek_function(stream.get(), seek_memory);
  opj_stream_set_skip_function(stream.get(), skip_memory);
  return stream;
}

void keep_message(const char* message, void* user) {
  auto& kept = *static_cast<std::string*>(user);
  if (kept.empty()) kept = message;
  while (!kept.empty() && kept.back() == '\n') kept.pop_back();
}

Image new_image(int width, int height, int bits) {
  opj_image_cmptparm_t component{};
  component.dx = component.dy = 1;
  component.w = static_cast<OPJ_UINT32>(width);
  component.h = static_cast<OPJ_UINT32>(height);
  component.prec = static_cast<OPJ_UINT32>(bits);
  Image image(opj_image_create(1, &component, OPJ_CLRSPC_GRAY));
  if (image) {
    image->x1 = component.w;
    image->y1 = component.h;
  }
  return image;
}

tl::unexpected<Error> failed(const std::string& message) {
  return fail(ErrorCode::kBadData, "OpenJPEG: " + (message.empty() ? "it does not say why" : message));
}

}  // namespace

Expected<std::vector<std::byte>> encode_plane(const Plane& plane, double loss) {
  const std::vector<std::byte> header = main_header(plane.width, plane.height, plane.bits);
  opj_cparameters_t parameters;
  opj_set_default_encoder_parameters(&parameters);
  parameters.numresolution = resolutions(plane.width, plane.height);
  parameters.tcp_numlayers = 1;
  parameters.irreversible = 0;
  if (loss > 0) {
    const double peak = std::ldexp(1, plane.bits) - 1;
    parameters.cp_fixed_quality = 1;
    parameters.tcp_distoratio[0] = static_cast<float>(20 * std::log10(peak / loss));
  } else {
    parameters.cp_disto_alloc = 1;
  }
  std::string comment;
  parameters.cp_comment = comment.data();
  const Image image = new_image(plane.width, plane.height, plane.bits);
  const Codec codec(opj_create_compress(OPJ_CODEC_J2K));
  Memory memory;
  const Stream stream = open_stream(memory, false);
  if (!image || !codec || !stream) return fail(ErrorCode::kIo, "OpenJPEG is out of memory");
  std::ranges::copy(plane.samples, image->comps[0].data);
  std::string message;
  opj_set_error_handler(codec.get(), keep_message, &message);
  if (!opj_setup_encoder(codec.get(), &parameters, image.get()) ||
      !opj_start_compress(codec.get(), image.get(), stream.get()) || !opj_encode(codec.get(), stream.get()) ||
      !opj_end_compress(codec.get(), stream.get())) {
    return failed(message);
  }
  // What decode_plane() will put before the body must be what the library wrote.
  const std::vector<std::byte>& out = memory.bytes;
  if (out.size() < header.size() || !std::equal(header.begin(), header.end(), out.begin())) {
    return failed("writes another header than expected");
  }
  std::size_t at = header.size();
  const auto number = [&](std::size_t place, int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i)
      value = value << 8 | static_cast<std::uint32_t>(out[place + static_cast<std::size_t>(i)]);
    return value;
  };
  while (at + 4 < out.size() && number(at, 2) != 0xff90) at += 2 + number(at + 2, 2);  // comments
  if (at + kTileHeader + kEnd > out.size() || number(at + 12, 2) != 0xff93 ||
      number(out.size() - kEnd, 2) != kEndMarker) {
    return failed("writes another tile part than expected");
  }
  return std::vector<std::byte>(out.begin() + static_cast<std::ptrdiff_t>(at + kTileHeader),
                                out.end() - static_cast<std::ptrdiff_t>(kEnd));
}

Expected<Plane> decode_plane(std::span<const std::byte> stream, int width, int height, int bits) {
  Memory memory{main_header(width, height, bits)};
  put_tile_header(memory.bytes, stream.size());
  memory.bytes.insert(memory.bytes.end(), stream.begin(), stream.end());
  put_number(memory.bytes, kEndMarker, 2);
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  const Codec codec(opj_create_decompress(OPJ_CODEC_J2K));
  const Stream source = open_stream(memory, true);
  if (!codec || !source) return fail(ErrorCode::kIo, "OpenJPEG is out of memory");
  std::string message;
  opj_set_error_handler(codec.get(), keep_message, &message);
  opj_image_t* raw = nullptr;
  const bool begun = opj_setup_decoder(codec.get(), &parameters) && opj_read_header(source.get(), codec.get(), &raw);
  const Image image(raw);
  if (!begun || !opj_decode(codec.get(), source.get(), image.get())) return failed(message);
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (image->numcomps != 1 || image->comps[0].data == nullptr || image->comps[0].w != static_cast<OPJ_UINT32>(width) ||
      image->comps[0].h != static_cast<OPJ_UINT32>(height)) {
    return failed("no plane of the expected size");
  }
  Plane plane{width, height, bits, {}};
  plane.samples.assign(image->comps[0].data, image->comps[0].data + count);
  return plane;
}

}  // namespace tintree::codec
