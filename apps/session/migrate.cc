#include <iostream>

#include "apps/session/commands.h"
#include "backend/store/session_format.h"
#include "backend/store/session_reader.h"

namespace arborslam {

int SessionMigrate(const std::string& path) {
  const int format = MigrateSessionFile(path);
  if (format == kSessionFormat) {
    std::cout << path << ": is of the present format " << kSessionFormat << " already\n";
  } else {
    std::cout << path << ": migrated from format " << format << " to " << kSessionFormat << "\n";
  }
  return 0;
}

}  // namespace arborslam
