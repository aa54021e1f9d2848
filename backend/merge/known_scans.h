#ifndef ARBORSLAM_BACKEND_MERGE_KNOWN_SCANS_H_
#define ARBORSLAM_BACKEND_MERGE_KNOWN_SCANS_H_

#include <cstdint>
#include <set>

#include "backend/store/session_contents.h"

namespace arborslam {

/// The scans that a session holds, by their fingerprints: a recording that is given twice would agree with itself in
/// every error.
class KnownScans {
 public:
  /// None.
  KnownScans() = default;
  /// All that `session` read. Those of sessions that were made before there were fingerprints are not known.
  explicit KnownScans(const SessionContents& session);

  /// True if a scan with this `FingerprintOf` is among them; false for 0, which stands for an unknown one.
  bool Hold(uint64_t fingerprint) const { return fingerprints_.count(fingerprint) > 0; }

 private:
  std::set<uint64_t> fingerprints_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_MERGE_KNOWN_SCANS_H_
