#include "backend/store/compression.h"

#include <glog/logging.h>
#include <zstd.h>

#include "core/error.h"

namespace arborslam {
namespace {

constexpr int kLevel = 1;
// A frame that claims to hold more is damaged: a piece of a session is a scan, a submap or a state.
constexpr unsigned long long kMostBytes = 1ull << 28;

}  // namespace

void Compressor::Deleter::operator()(ZSTD_CCtx_s* context) const { ZSTD_freeCCtx(context); }

Compressor::Compressor() : context_(ZSTD_createCCtx()) {
  CHECK(context_ != nullptr);
  ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1);
}

std::string Compressor::Compress(std::string_view bytes) {
  std::string frame(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size = ZSTD_compress2(context_.get(), frame.data(), frame.size(), bytes.data(), bytes.size());
  CHECK(ZSTD_isError(size) == 0) << ZSTD_getErrorName(size);
  frame.resize(size);
  return frame;
}

std::string Decompress(std::string_view frame, const std::string& place) {
  const auto fail = [&place](const std::string& problem) {
    throw UserError(place, "is damaged: " + problem, "use a copy, or map the recording again");
  };
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > kMostBytes) {
    fail("it is not packed as a session's pieces are");
  }
  std::string bytes(static_cast<size_t>(size), '\0');
  const size_t unpacked = ZSTD_decompress(bytes.data(), bytes.size(), frame.data(), frame.size());
  if (ZSTD_isError(unpacked) != 0) fail(ZSTD_getErrorName(unpacked));
  if (unpacked != bytes.size()) fail("it is cut short");
  return bytes;
}

}  // namespace arborslam
