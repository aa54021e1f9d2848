#ifndef ARBORSLAM_BACKEND_STORE_FINGERPRINT_H_
#define ARBORSLAM_BACKEND_STORE_FINGERPRINT_H_

#include <cstdint>

#include "core/io/scan_source.h"

namespace arborslam {

/// A number, never 0, that tells a scan from any other by its stamp and its measurements: by it a session knows the
/// recording that it was made from. The same on every machine of one byte order.
uint64_t FingerprintOf(const Scan& scan);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_FINGERPRINT_H_
