#ifndef ARBORSLAM_BACKEND_STORE_MEMORY_OPTIONS_H_
#define ARBORSLAM_BACKEND_STORE_MEMORY_OPTIONS_H_

#include <memory>
#include <string>

#include "core/io/value_store.h"

namespace arborslam {

struct MemoryOptions {
  /// [MiB], of the scans and submaps of a run that are kept in memory; others lie in a temporary file. 0: all are kept.
  double max_size = 512.0;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("max_size", max_size);
  }
};

/// The store of a run's scans and submaps; null if all are kept. Its file, should it need one, is made in the folder
/// that the environment variable TMPDIR names, else in /var/tmp.
std::shared_ptr<ValueStore> MakeStore(const MemoryOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_MEMORY_OPTIONS_H_
