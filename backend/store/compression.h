#ifndef ARBORSLAM_BACKEND_STORE_COMPRESSION_H_
#define ARBORSLAM_BACKEND_STORE_COMPRESSION_H_

#include <memory>
#include <string>
#include <string_view>

struct ZSTD_CCtx_s;

namespace arborslam {

/// Packs bytes, quickly rather than tightly. Keeps its memory from one call to the next.
class Compressor {
 public:
  Compressor();

  /// `bytes` as a Zstandard frame with a checksum.
  std::string Compress(std::string_view bytes);

 private:
  struct Deleter {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_CCtx_s, Deleter> context_;
};

/// The inverse of `Compressor::Compress`. Throws `UserError`, naming `place`, for bytes that are no such frame or are
/// damaged.
std::string Decompress(std::string_view frame, const std::string& place);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_COMPRESSION_H_
