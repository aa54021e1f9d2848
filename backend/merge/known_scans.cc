#include "backend/merge/known_scans.h"

namespace arborslam {

KnownScans::KnownScans(const SessionContents& session) {
  for (const SessionContents::ReadScan& scan : session.read) {
    if (scan.fingerprint != 0) fingerprints_.insert(scan.fingerprint);
  }
}

}  // namespace arborslam
