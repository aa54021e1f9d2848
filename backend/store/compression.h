#ifndef ARBORSLAM_BACKEND_STORE_COMPRESSION_H_
#define ARBORSLAM_BACKEND_STORE_COMPRESSION_H_

#include <string>
#include <string_view>

namespace arborslam {

/// `bytes` as a Zstandard frame with a checksum, packed quickly rather than tightly.
std::string Compress(std::string_view bytes);

/// The inverse of `Compress`. Throws `UserError`, naming `place`, for bytes that are no such frame or are damaged.
std::string Decompress(std::string_view frame, const std::string& place);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_COMPRESSION_H_
