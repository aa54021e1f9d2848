#include "backend/store/memory_options.h"

#include <cstddef>
#include <cstdlib>

#include "core/config/validation.h"

namespace arborslam {

std::string MemoryOptions::Validate() const {
  if (!(max_size >= 0.0 && max_size <= 1e6)) return Violation("max_size", max_size, "lie in [0, 1000000] MiB");
  return "";
}

std::shared_ptr<ValueStore> MakeStore(const MemoryOptions& options) {
  if (options.max_size == 0.0) return nullptr;
  // In memory, as /tmp often is, the file would save nothing.
  const char* const folder = std::getenv("TMPDIR");
  return std::make_shared<ValueStore>(folder != nullptr && *folder != '\0' ? folder : "/var/tmp",
                                      static_cast<size_t>(options.max_size * 1024.0 * 1024.0));
}

}  // namespace arborslam
